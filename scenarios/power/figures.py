"""The figures of a plan's power: what can be seen, from which size on, and what else a fault may seem."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np
import plotly.graph_objects as go

from armtwin.scenarios.power.place import PlacePower
from armtwin.scenarios.power.words import axis, label, shown_size
from armtwin.scenarios.report.style import COLOURS, add_band, figure

_SEEN, _HALF = COLOURS["extended"], COLOURS["geometry"]
_PLACES = (COLOURS["extended"], COLOURS["armtwin"], COLOURS["paper"])
_FIXED = "#c4c4c4"
_HEIGHT = 290


def sizes_found(places: Sequence[PlacePower], unit: str) -> go.Figure:
    """Return, for the faults of one unit, the sizes found in 50 and in 90 of 100 recordings."""
    shown = [one for one in places if one.unit == unit and one.size_50 is not None and not one.fixed]
    shown.sort(key=lambda one: one.size_90 or one.size_50 or 0.0, reverse=True)
    fig = figure(axis(unit), "", height=130 + 22 * len(shown))
    names = [label(one.effect, one.site) for one in shown]
    for one, name in zip(shown, names, strict=True):
        ends = [size for size in (one.size_50, one.size_90) if size is not None]
        fig.add_scatter(
            x=shown_size(np.array(ends), unit),
            y=[name] * len(ends),
            mode="lines",
            line={"color": _SEEN, "width": 5},
            opacity=0.35,
            showlegend=False,
            hoverinfo="skip",
        )
    for legend, colour, sizes in (
        ("in 50 of 100", _HALF, [one.size_50 for one in shown]),
        ("in 90 of 100", _SEEN, [one.size_90 for one in shown]),
    ):
        x = [None if size is None else float(shown_size(np.array(size), unit)) for size in sizes]
        fig.add_scatter(x=x, y=names, mode="markers", name=legend, marker={"color": colour, "size": 9})
    fig.update_xaxes(type="log", dtick=1)
    fig.update_yaxes(tickfont_size=11)
    fig.update_layout(margin={"l": 165})
    return fig


def found_curves(places: Sequence[PlacePower]) -> go.Figure:
    """Return found against size for one effect, a line and a band a place."""
    unit = places[0].unit
    fig = figure(axis(unit), "found", height=_HEIGHT, title=places[0].effect)
    for colour, one in zip(_PLACES, places, strict=False):
        x = shown_size(np.array(one.sizes), unit)
        add_band(fig, x.tolist(), one.low, one.high, colour, opacity=0.15)
        fig.add_scatter(x=x, y=one.found, mode="lines", name=str(one.site), line={"color": colour, "width": 2})
    fig.update_xaxes(type="log", dtick=1)
    fig.update_yaxes(range=[-0.03, 1.03], tickformat=".0%")
    fig.update_layout(legend={"y": -0.4, "yanchor": "top"}, margin={"b": 90, "t": 50})
    return fig


def said_of(places: Sequence[PlacePower]) -> dict[str, Counter[str]]:
    """Count, of each effect, what is said at half the size found in 90 of 100, in thousandths of the recordings."""
    said: dict[str, Counter[str]] = {}
    for one in places:
        for answer, share in one.taken_for.items():
            said.setdefault(one.effect, Counter())[answer] += round(1000 * share)
    return said
