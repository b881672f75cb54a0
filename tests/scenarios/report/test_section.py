"""The blocks that a report is made of."""

import numpy as np

from armtwin.scenarios.report.page import page
from armtwin.scenarios.report.section import Section, gallery, number, plot, prose, table, with_std
from armtwin.scenarios.report.style import figure


def test_text_of_a_file_cannot_become_markup() -> None:
    assert "<script>" not in prose("<script>alert(1)</script>")
    assert "<b>" not in table(["<b>"], [["<b>", 1.0]], "<b>")
    assert '"><b>' not in gallery([('"><b>', np.zeros((4, 4, 3), np.uint8))], "")


def test_a_number_has_a_true_minus_and_a_missing_one_a_dash() -> None:
    assert number(-1.23456, 2, "mm") == "−1.23 mm"
    assert number(None) == "–"
    assert number(float("nan")) == "–"


def test_a_deviation_that_is_not_known_is_left_out() -> None:
    assert with_std(1.5, 0.25, 2) == "1.50 ± 0.25"
    assert with_std(1.5, None, 2) == "1.50"


def test_a_figure_does_not_bring_plotly_itself() -> None:
    assert len(plot(figure("x, mm", "y, mm"), "a caption")) < 20000


def test_sections_stand_in_the_order_given_and_can_be_reached() -> None:
    whole = page("title", "about", [("1", "answer")], [Section("b", "Second", "…"), Section("a", "First", "…")])
    assert whole.index('<section id="b">') < whole.index('<section id="a">')
    assert 'href="#a"' in whole
