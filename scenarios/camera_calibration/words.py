"""A camera's calibration told on the terminal and in the head of its file."""

from __future__ import annotations

import numpy as np
from rich.console import Console
from rich.table import Table
from rich.text import Text

from armtwin.calib.camera import CameraCalibration
from armtwin.calib.camera.comparison import Comparison, bow_of
from armtwin.calib.camera.models import USUAL
from armtwin.scenarios.camera_calibration.job import CameraJob
from armtwin.scenarios.camera_calibration.pose import PlacedCamera

# A pose found with given intrinsics leaves this many pixels where they are right; beyond, they are another camera's.
_FITTING_PX = 1.0


def number(value: float, form: str) -> str:
    """Format a number, or a dash where it could not be had."""
    return format(value, form) if np.isfinite(value) else "–"


def comment(fit: CameraCalibration) -> str:
    """Return the head of the camera's file."""
    lines = [
        f"Calibrated by armtwin from {len(fit.views)} views of a board: {fit.board}, squares of "
        f"{fit.board.square_mm:g} mm; model {fit.model.name}; RMS {fit.rms_px:.4f} px.",
        f"The pose is that of the board in {fit.views[fit.reference].name}: X_camera = R X_board + t.",
        "Standard deviations (the largest of: independent corners, left-out views, parts of the image):",
        *(f"  {name}: {std:.3g}" for name, std in fit.total_std.items()),
    ]
    return "\n".join(lines)


def tell(console: Console, job: CameraJob) -> None:
    """Print all of a calibration."""
    fit = job.calibration
    console.print(f"{len(fit.views)} views of {fit.board}, {fit.model.name}, RMS [bold]{fit.rms_px:.3f} px[/bold]")
    console.print(_parameter_table(job))
    if job.comparison is not None:
        console.print(_model_table(job.comparison))
    console.print(_view_table(job))
    coverage = fit.coverage
    console.print(
        f"Coverage: corners span {coverage.hull_share:.0%} of the image and reach {coverage.reach_share:.0%} "
        "of the way to its corners"
    )
    for line in job.seen.told:
        console.print(Text(line))
    for line in advice_lines(job):
        console.print(Text("→ " + line))


def tell_pose(console: Console, placed: PlacedCamera) -> None:
    """Print the pose of a camera whose intrinsics were given."""
    t, std = placed.camera.t_board_camera_mm, placed.pose_std[3:]
    places = ", ".join(f"{value:.2f} ± {error:.2f}" for value, error in zip(t, std, strict=True))
    console.print(f"Pose from {placed.name}: board at {places} mm before the camera, RMS {placed.rms_px:.3f} px")
    if placed.rms_px > _FITTING_PX:
        console.print(
            Text(
                f"→ the given intrinsics leave {placed.rms_px:.2f} px: another camera's, another focus or zoom, or a "
                "board that is not flat; calibrate without --intrinsics"
            )
        )


def advice_lines(job: CameraJob) -> list[str]:
    """Say what would make the calibration better, one line each."""
    fit, lines = job.calibration, []
    if job.comparison is not None and job.comparison.chosen != fit.model:
        mean, error = job.comparison.gain(job.comparison.chosen)
        if fit.model == USUAL:
            lines.append(
                f"use --model {job.comparison.chosen.name}: {1 - np.exp(mean):.0%} (± {error:.0%}) less error in views "
                f"left out; {job.comparison.chosen.says}"
            )
        else:
            lines.append(f"use --model {job.comparison.chosen.name}: it predicts views left out better")
    if fit.model.bow:
        bowed = next(one for one in job.comparison.models if one.model == fit.model) if job.comparison else None
        lines.append(f"the board bows by {bow_of(bowed) if bowed else 'some'}: glue it to a flat plate")
    rms = dict(zip((view.name for view in fit.views), fit.per_view_rms_px, strict=True))
    median = float(np.median(fit.per_view_rms_px))
    lines += [
        f"drop {name}: {rms[name]:.2f} px where half of the views have {median:.2f} px or less"
        for name in fit.advice.drop
    ]
    unseen = [name for name in job.seen.unseen if name not in job.seen.late]
    if unseen:
        lines.append(f"retake or leave out, the whole board was not found: {', '.join(unseen)}")
    if job.seen.late:
        lines.append(f"retake before a plainer background, the search took too long: {', '.join(job.seen.late)}")
    lines += [f"add {what}" for what in fit.advice.add]
    return lines or ["nothing to drop or add"]


def model_rows(comparison: Comparison) -> list[list[str]]:
    """Name, adjusted parameters, RMS, held-out error and ratio to the usual model of each, and what the best means."""
    rows = []
    for one in comparison.models:
        mean, error = comparison.gain(one.model)
        ratio = "" if one.model == USUAL else f"{np.exp(mean) - 1.0:+.1%} ± {error:.1%}"
        chosen = one.model == comparison.chosen
        rows.append(
            [
                one.model.name,
                str(len(one.model.free)),
                f"{one.rms_px:.3f}",
                number(one.typical_px, ".3f"),
                ratio,
                f"best: {one.model.says}" if chosen else "",
            ]
        )
    return rows


def _model_table(comparison: Comparison) -> Table:
    columns = ("model", "free", "RMS px", "held out px", "error", "")
    table = Table(*columns, box=None, pad_edge=False)
    table.columns[0].no_wrap = True
    for column in table.columns[1:5]:
        column.justify = "right"
    for row in model_rows(comparison):
        table.add_row(*row, style="bold" if row[-1] else None)
    return table


def _parameter_table(job: CameraJob) -> Table:
    fit = job.calibration
    table = Table("", "value", "± (all told)", "± (corners)", "± (views)", *job.variants, box=None, pad_edge=False)
    for column in table.columns[1:]:
        column.justify = "right"
    nan = float("nan")
    for name, value in fit.intrinsics.items():
        digits = 2 if name[0] in "fc" else 5
        cells = [value, *(stds.get(name, nan) for stds in (fit.total_std, fit.std, fit.jackknife_std))]
        cells += [variant.intrinsics[name] for variant in job.variants.values()]
        unit = " px" if name[0] in "fc" else ""
        table.add_row(name + unit, *(number(cell, f".{digits}f") for cell in cells))
    rms = [f"{variant.rms_px:.3f}" for variant in job.variants.values()]
    table.add_row("RMS px", f"{fit.rms_px:.3f}", "", "", "", *rms)
    return table


def _view_table(job: CameraJob) -> Table:
    fit = job.calibration
    table = Table("view", "RMS px", "tilt °", "fx without it", "", box=None, pad_edge=False)
    for column in table.columns[1:4]:
        column.justify = "right"
    tilt_deg = fit.tilt_deg
    for i, view in enumerate(fit.views):
        notes = [
            "drop" if view.name in fit.advice.drop else "",
            "reference" if i == fit.reference else "",
        ]
        change = fit.uncertainty.without_view[i, 0]
        style = "bold red" if view.name in fit.advice.drop else None
        cells = [f"{fit.per_view_rms_px[i]:.3f}", f"{tilt_deg[i]:.0f}", f"{change:+.2f} px"]
        table.add_row(Text(view.name), *cells, ", ".join(note for note in notes if note), style=style)
    for name in job.seen.unseen:
        why = "took too long" if name in job.seen.late else "board not found"
        table.add_row(Text(name), "-", "-", "-", why, style="yellow")
    return table
