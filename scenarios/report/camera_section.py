"""The camera's calibration beside Table 2."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go

from scenarios.report.data import RunData
from scenarios.report.section import Section, gallery, number, plot, table, with_std
from scenarios.report.style import COLOURS, figure
from scenarios.runner.frames import read_frame

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
    worst = max(abs(r["estimate"] - r["truth"]) / r["std"] for r in rows if r["parameter"] in ("fx", "fy", "cx", "cy"))
    return Section(
        slug="camera",
        title="The camera, calibrated (Table 2)",
        lead=(
            f"{len(stage['views'])} views of a 10×7 chessboard give back the lens that the pictures were drawn through, "
            f"to {stage['rms_px']:.2f} px a corner; focal length and centre lie within {worst:.1f} standard deviations "
            "of the truth."
        ),
        blocks=(
            table(
                ["parameter", "paper (Table 2)", "truth here", "found ± σ", "off by σ"],
                [
                    [
                        _SYMBOLS.get(r["parameter"], r["parameter"]),
                        number(r["paper"]),
                        number(r["truth"]),
                        with_std(r["estimate"], r["std"]),
                        number((r["estimate"] - r["truth"]) / r["std"], 1),
                    ]
                    for r in rows
                ],
                "The paper's own values are the truth of this bench. σ holds if corners err independently; k2 and k3 "
                "trade against each other, so each is known much worse than the curve that they make.",
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
                _corners(run), "Corners of all views over the picture: where there are none, the lens is extrapolated."
            ),
        ),
    )


def _corners(run: RunData) -> go.Figure:
    corners = np.concatenate([np.array(view) for view in run.stage("camera")["corners_px"]])
    camera = run.truth["camera"]
    fig = figure("u, px", "v, px", height=430)
    fig.add_scatter(
        x=corners[:, 0],
        y=corners[:, 1],
        mode="markers",
        name="corner",
        marker={"size": 4, "color": COLOURS["armtwin"], "opacity": 0.6},
    )
    fig.update_xaxes(range=[0, camera["image_width"]])
    fig.update_yaxes(range=[camera["image_height"], 0], scaleanchor="x")
    return fig
