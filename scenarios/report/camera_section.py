"""The camera's calibration beside Table 2."""

from __future__ import annotations

from typing import Any

import numpy as np
import plotly.graph_objects as go

from armtwin.scenarios.report.data import RunData
from armtwin.scenarios.report.section import Section, gallery, number, plot, table, with_std
from armtwin.scenarios.report.style import COLOURS, figure
from armtwin.scenarios.runner.frames import read_frame

_SHOWN_VIEWS = 6
_SYMBOLS = {
    "fx": "f_x, px",
    "fy": "f_y, px",
    "cx": "c_x, px",
    "cy": "c_y, px",
    "tx": "t_x, mm",
    "ty": "t_y, mm",
    "tz": "t_z, mm",
    "rotation": "turned from the truth, rad",
}


def camera_section(run: RunData) -> Section:
    """Show Table 2 beside the truth, the views, and where in the picture corners were seen."""
    rows = run.results["tables"]["2"]
    stage = run.stage("camera")
    f = next(r for r in rows if r["parameter"] == "fx")
    return Section(
        slug="camera",
        title="The camera, calibrated (Table 2)",
        lead=(
            f"{len(stage['views'])} views of a 10×7 chessboard give back the lens that the pictures came through, "
            f"to {stage['rms_px']:.2f} px a corner; the focal length is {abs(f['estimate'] / f['truth'] - 1):.2%} off."
        ),
        blocks=(
            table(
                ["parameter", "paper (Table 2)", "truth here", "found ± σ", "off by σ"],
                [
                    [
                        _SYMBOLS.get(r["parameter"], r["parameter"]),
                        number(r["paper"], _digits(r)),
                        number(r["truth"], _digits(r)),
                        with_std(r["estimate"], r["std"], _digits(r)),
                        number((r["estimate"] - r["truth"]) / r["std"], 1),
                    ]
                    for r in rows
                ],
                "Table 2's lens is the one that this bench draws through. σ holds if all corners err independently; "
                "neighbours do not quite (one blur, one light), so a few σ are no surprise. k2 and k3 trade against "
                "each other: each is known much worse than the curve that they make.",
                marked=[3],
            ),
            gallery(
                [
                    (f"{name}: {rms:.2f} px", read_frame(run.out / "board", int(name.split(".")[0]))[::2, ::2])
                    for name, rms in list(zip(stage["views"], stage["per_view_rms_px"], strict=True))[:_SHOWN_VIEWS]
                ],
                "The first views, with the root mean square error of their corners. The first, the board in its "
                "mount behind the arm, gives the camera's pose.",
            ),
            plot(
                _corners(run), "Corners of all views over the picture. Where there are none, the lens is extrapolated."
            ),
        ),
    )


def _digits(row: dict[str, Any]) -> int:
    return 5 if row["parameter"] in ("p1", "p2", "rotation") else 4


def _corners(run: RunData) -> go.Figure:
    corners = np.concatenate([np.array(view) for view in run.stage("camera")["corners_px"]])
    camera = run.truth["camera"]
    fig = figure("u, px", "v, px", height=470)
    fig.add_scatter(
        x=corners[:, 0],
        y=corners[:, 1],
        mode="markers",
        name="corner",
        marker={"size": 4, "color": COLOURS["armtwin"], "opacity": 0.6},
    )
    fig.update_xaxes(range=[0, camera["image_width"]], constrain="domain")
    fig.update_yaxes(range=[camera["image_height"], 0], scaleanchor="x", constrain="domain")
    return fig
