"""Reports as a person opens them: in a browser, at a desk and on a phone."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from armtwin.scenarios.report.page import page
from armtwin.scenarios.report.section import Section, plot, plots, prose, table
from armtwin.scenarios.report.style import figure
from tests.support.browser import CHROMIUM, DESK_PX, PHONE_PX, chromium, faults_of

pytestmark = [
    pytest.mark.skipif(CHROMIUM is None, reason="no Chromium on this machine"),
    pytest.mark.xdist_group("browser"),
]


@pytest.fixture(scope="module")
def browser():  # type: ignore[no-untyped-def]
    with chromium() as started:
        yield started


def _page(path: Path, *blocks: object) -> Path:
    path.write_text(page("A title", "about", [("1 mm", "an answer")], [Section("s", "S", "…", tuple(blocks))]), "utf-8")  # type: ignore[arg-type]
    return path


@pytest.mark.parametrize("width_px", [DESK_PX, PHONE_PX])
def test_wide_tables_and_long_titles_are_whole_at_a_desk_and_on_a_phone(browser, tmp_path: Path, width_px: int) -> None:  # type: ignore[no-untyped-def]
    header = ["effect", "at", "explains", "parameter", "value", "95 % interval", "p-value"]
    row = ["gravity_sag", "whole arm", "2.9 %", "compliance1_rad_per_nm", "0.1208", "0.1202 to 0.1214", "< 1e-12"]
    figures = [
        figure("gravity's torque about joint 2, N m", "joint 2 appears off by, °", title=f"{k}") for k in range(3)
    ]
    for fig in figures:
        fig.add_scatter(y=np.arange(5.0))
    file = _page(
        tmp_path / "page.html", table(header, [row], "A wide table."), plots(figures, "Three."), prose("Text.")
    )
    assert faults_of(browser, file, width_px) == []


def test_a_page_that_asks_the_network_or_cuts_a_figure_is_seen(browser, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    fig = figure("x", "y")
    fig.update_layout(title={"text": "a title that is far too long for a figure on a phone, and goes on", "x": 0.0})
    file = _page(tmp_path / "bad.html", plot(fig, "One."))
    text = file.read_text("utf-8").replace("</main>", '<img src="http://127.0.0.1:9/x.png" alt=""></main>')
    file.write_text(text, "utf-8")
    faults = faults_of(browser, file, PHONE_PX)
    assert any("asks for" in fault for fault in faults)
    assert any("cut off" in fault for fault in faults)
