"""Equation (8) as it is printed."""

from armtwin.scenarios.runner.paper_checks import printed_equation_8_error_mm


def test_the_printed_equation_8_misses_the_papers_own_circles_by_centimetres() -> None:
    assert printed_equation_8_error_mm() > 40.0
