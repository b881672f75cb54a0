"""The page of a camera calibration: one file that opens offline."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import plotly.graph_objects as go
import plotly.io as pio
from jinja2 import Environment, StrictUndefined
from numpy.typing import NDArray

from armtwin.calib.camera import INTRINSICS, CameraCalibration
from armtwin.calib.camera.advice import tilts
from armtwin.calib.camera.fit import rotations_of

_PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>Camera calibration</title>
<style>
 body { font: 15px/1.5 system-ui, sans-serif; max-width: 60rem; margin: 2rem auto; padding: 0 1rem; color: #222 }
 table { border-collapse: collapse; margin: 1rem 0 } td, th { padding: .15rem .8rem; text-align: right }
 td:first-child, th:first-child { text-align: left } tr { border-bottom: 1px solid #ddd }
 figure { margin: 1.5rem 0 } figcaption { color: #555 }
</style></head><body>
<h1>Camera calibration</h1>
<p>{{ n_views }} views of {{ board }}, squares of {{ square_mm }} mm, {{ width }}×{{ height }} px.
Root mean square distance of measured and predicted corners: <b>{{ rms }} px</b>.</p>
<table><tr><th>parameter</th><th>value</th><th>± if corners err alike</th><th>± from leaving out views</th>
{% for name in variants %}<th>{{ name }}</th>{% endfor %}</tr>
{% for row in rows %}<tr>{% for cell in row %}<td>{{ cell }}</td>{% endfor %}</tr>{% endfor %}</table>
<p>The first uncertainty takes every corner for an independent measurement. The second leaves out each view in turn;
where it is clearly larger, whole views are wrong together (a bent board, a window that sees two corners, blur by
motion).</p>
<h2>What would make it better</h2>
<ul>{% for line in advice %}<li>{{ line }}</li>{% endfor %}</ul>
{% for caption, figure in figures %}<figure>{{ figure|safe }}<figcaption>{{ caption }}</figcaption></figure>{% endfor %}
</body></html>
"""


def report_page(fit: CameraCalibration, variants: Mapping[str, CameraCalibration], advice: Sequence[str]) -> str:
    """Return the page as HTML, scripts included."""
    figures = [
        ("Error of each view. Red: out of line with the others.", _errors(fit)),
        ("Corners seen, over the picture. Where there are none, the distortion is extrapolated.", _coverage(fit)),
        (
            "Measured less predicted corners. A round cloud is noise; a view that stands aside is wrong as a whole.",
            _residuals(fit),
        ),
        (
            "Tilt of the board, degrees, towards the side that is nearer. Views to all four sides beyond the inner "
            "circle of 15° fix the focal length.",
            _tilts(fit),
        ),
    ]
    rows = [
        [
            name,
            *(number(value, ".6g") for value in (fit.intrinsics[name], fit.std[name], fit.jackknife_std[name])),
            *(number(variant.intrinsics[name], ".6g") for variant in variants.values()),
        ]
        for name in INTRINSICS
    ]
    template = Environment(autoescape=True, undefined=StrictUndefined).from_string(_PAGE)
    return template.render(
        n_views=len(fit.views),
        board=str(fit.board),
        square_mm=f"{fit.board.square_mm:g}",
        width=fit.camera.image_width,
        height=fit.camera.image_height,
        rms=f"{fit.rms_px:.3f}",
        variants=list(variants),
        rows=rows,
        advice=advice,
        figures=[
            (caption, pio.to_html(figure, include_plotlyjs=i == 0, full_html=False, div_id=f"figure-{i}"))
            for i, (caption, figure) in enumerate(figures)
        ],
    )


def number(value: float, form: str) -> str:
    """Format a number, or a dash where it could not be had."""
    return format(value, form) if np.isfinite(value) else "–"


def _errors(fit: CameraCalibration) -> go.Figure:
    colours = ["#b00020" if view.name in fit.advice.drop else "#3367a6" for view in fit.views]
    bars = go.Bar(x=[view.name for view in fit.views], y=fit.per_view_rms_px, marker_color=colours)
    return _styled(go.Figure(bars), "view", "RMS, px")


def _coverage(fit: CameraCalibration) -> go.Figure:
    figure = go.Figure(_clouds(fit, [view.pixels for view in fit.views]))
    styled = _styled(figure, "u, px", "v, px")
    styled.update_xaxes(range=[0, fit.camera.image_width], constrain="domain")
    styled.update_yaxes(range=[fit.camera.image_height, 0], scaleanchor="x", constrain="domain")
    return styled


def _residuals(fit: CameraCalibration) -> go.Figure:
    styled = _styled(go.Figure(_clouds(fit, list(fit.residuals_px))), "u, px", "v, px")
    styled.update_yaxes(scaleanchor="x", autorange="reversed")
    return styled


def _tilts(fit: CameraCalibration) -> go.Figure:
    tilt_deg = np.rad2deg(tilts(rotations_of(fit.poses)))
    names = [view.name for view in fit.views]
    figure = go.Figure(go.Scatter(x=tilt_deg[:, 0], y=tilt_deg[:, 1], mode="markers", text=names, marker_size=9))
    for radius in (15, 45):
        figure.add_shape(type="circle", x0=-radius, x1=radius, y0=-radius, y1=radius, line={"color": "#bbb"})
    styled = _styled(figure, "left side nearer ← degrees → right side nearer", "degrees, downward: lower side nearer")
    styled.update_xaxes(range=[-60, 60], constrain="domain")
    styled.update_yaxes(range=[60, -60], scaleanchor="x", constrain="domain")
    return styled


def _clouds(fit: CameraCalibration, points: Sequence[NDArray[np.float64]]) -> list[go.Scatter]:
    return [
        go.Scatter(x=cloud[:, 0], y=cloud[:, 1], mode="markers", name=view.name, marker_size=4)
        for view, cloud in zip(fit.views, points, strict=True)
    ]


def _styled(figure: go.Figure, x: str, y: str) -> go.Figure:
    return figure.update_layout(
        template="plotly_white", height=480, margin={"l": 60, "r": 20, "t": 20, "b": 50}, xaxis_title=x, yaxis_title=y
    )
