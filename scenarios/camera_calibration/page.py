"""The page of a camera calibration: one file that opens offline."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import plotly.graph_objects as go
import plotly.io as pio
from jinja2 import Environment, StrictUndefined
from numpy.typing import NDArray

from armtwin.calib.camera import CameraCalibration
from armtwin.calib.camera.advice import tilts
from armtwin.calib.camera.fit import rotations_of
from armtwin.scenarios.camera_calibration.job import CameraJob
from armtwin.scenarios.camera_calibration.words import advice_lines, model_rows, number

# Cells of the image, each way, in which residuals are averaged; fewer corners than this in one tell nothing.
_FIELD_CELLS, _LEAST_IN_CELL = 12, 4
# A figure is as wide as the page, on a telephone too, and without buttons that would cover it there.
_CONFIG = {"responsive": True, "displayModeBar": False}
_PAGE = Path(__file__).with_name("page.html")


def report_page(job: CameraJob) -> str:
    """Return the page as HTML, scripts included."""
    fit = job.calibration
    figures = [
        ("Error of each view. Red: out of line with the others.", _errors(fit)),
        ("Corners seen, over the picture. Where there are none, the distortion is extrapolated.", _coverage(fit)),
        (
            "Measured less predicted corners. A round cloud is noise; a view that stands aside is wrong as a whole.",
            _residuals(fit),
        ),
        _field(fit),
        (
            "Tilt of the board, degrees, towards the side that is nearer. Views to all four sides beyond the inner "
            "circle of 15° fix the focal length.",
            _tilts(fit),
        ),
    ]
    spread = fit.uncertainty
    field = dict(zip(spread.names, spread.field_std.tolist(), strict=True))
    stds = (fit.total_std, fit.std, fit.jackknife_std, field)
    rows = [
        [
            name,
            number(value, ".6g"),
            *(number(std.get(name, np.nan), ".3g") for std in stds),
            *(number(variant.intrinsics[name], ".6g") for variant in job.variants.values()),
        ]
        for name, value in fit.intrinsics.items()
    ]
    template = Environment(autoescape=True, undefined=StrictUndefined).from_string(_PAGE.read_text("utf-8"))
    return template.render(
        n_views=len(fit.views),
        board=str(fit.board),
        square_mm=f"{fit.board.square_mm:g}",
        width=fit.camera.image_width,
        height=fit.camera.image_height,
        rms=f"{fit.rms_px:.3f}",
        variants=list(job.variants),
        model=fit.model.name,
        models=model_rows(job.comparison) if job.comparison else [],
        rows=rows,
        advice=[*job.seen.told, *advice_lines(job)],
        figures=[
            (caption, pio.to_html(figure, _CONFIG, include_plotlyjs=i == 0, full_html=False, div_id=f"figure-{i}"))
            for i, (caption, figure) in enumerate(figures)
        ],
    )


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


def _field(fit: CameraCalibration) -> tuple[str, go.Figure]:
    """Mean residual in each cell of the image, as arrows, and what to say of them."""
    size = np.array([fit.camera.image_width, fit.camera.image_height])
    pixels = np.concatenate([view.pixels for view in fit.views])
    residuals = np.concatenate(fit.residuals_px)
    cell = np.clip((pixels + 0.5) / size * _FIELD_CELLS, 0, _FIELD_CELLS - 1).astype(int)
    groups = [np.all(cell == place, axis=1) for place in np.unique(cell, axis=0)]
    groups = [inside for inside in groups if inside.sum() >= _LEAST_IN_CELL]
    at = np.array([pixels[inside].mean(axis=0) for inside in groups]).reshape(-1, 2)
    mean = np.array([residuals[inside].mean(axis=0) for inside in groups]).reshape(-1, 2)
    longest = float(np.percentile(np.linalg.norm(mean, axis=1), 95)) if len(mean) else 0.0
    scale = size[0] / _FIELD_CELLS / longest if longest > 0.0 else 1.0
    figure = go.Figure()
    for start, end in zip(at, at + scale * mean, strict=True):
        figure.add_annotation(
            {"x": end[0], "y": end[1], "ax": start[0], "ay": start[1], "axref": "x", "ayref": "y", "showarrow": True}
            | {"arrowhead": 2, "arrowwidth": 1.5, "arrowcolor": "#3367a6", "text": ""}
        )
    styled = _styled(figure, "u, px", "v, px")
    styled.update_xaxes(range=[0, size[0]], constrain="domain")
    styled.update_yaxes(range=[size[1], 0], scaleanchor="x", constrain="domain")
    return (
        f"What the model leaves in each part of the image: the mean of the residuals there, drawn {scale:.0f} times as "
        f"long; the longer ones are {longest:.2f} px. Arrows in a pattern are a lens that the model does not follow; "
        "without order, noise.",
        styled,
    )


def _tilts(fit: CameraCalibration) -> go.Figure:
    tilt_deg = np.rad2deg(tilts(rotations_of(fit.poses)))
    names = [view.name for view in fit.views]
    figure = go.Figure(go.Scatter(x=tilt_deg[:, 0], y=tilt_deg[:, 1], mode="markers", text=names, marker_size=9))
    for radius in (15, 45):
        figure.add_shape(type="circle", x0=-radius, x1=radius, y0=-radius, y1=radius, line={"color": "#bbb"})
    styled = _styled(figure, "left nearer ← degrees → right nearer", "degrees, downward: lower nearer")
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
