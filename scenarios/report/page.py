"""The page: sections one after the other, with plotly.js brought along once, so that it opens offline."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from pathlib import Path

from markupsafe import Markup
from plotly.offline import get_plotlyjs

from armtwin.scenarios.report.section import Section
from armtwin.scenarios.report.style import COLOURS
from armtwin.scenarios.report.templates import render

_CSS = Path(__file__).parent / "templates" / "page.css"


def page(
    title: str,
    about: str,
    answers: Sequence[tuple[str, str]],
    sections: Sequence[Section],
    key: Collection[str] = COLOURS.keys(),
) -> str:
    """Return the whole HTML.

    `answers` are the few (value, what it is) that stand at the top, `key` the colours' names that the page uses.
    """
    return render(
        "page.html",
        title=title,
        about=about,
        answers=answers,
        sections=sections,
        colours=[(name, colour) for name, colour in COLOURS.items() if name in key],
        css=Markup(_CSS.read_text("utf-8")),  # noqa: S704  # our own file
        plotly=Markup(get_plotlyjs()),  # noqa: S704  # the library's own script
    )
