"""`armtwin calibrate-camera`: a camera file from photographs of a chessboard, with how far to trust it."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich.console import Console
from rich.progress import track
from rich.table import Table
from rich.text import Text

from armtwin.calib.camera import INTRINSICS, Board, CameraCalibration, Corners, calibrate_camera, find_corners
from armtwin.calib.camera.board import MIN_CORNERS
from armtwin.calib.camera.corners import USUAL_WINDOW_PX, window_limit_px
from armtwin.calib.camera.fit import MIN_VIEWS
from armtwin.calib.camera.images import Gray, find_images, read_views
from armtwin.models.atomic import write_text
from armtwin.models.camera_files import write_camera
from armtwin.models.errors import InputError, nearest
from armtwin.scenarios.commands.calibrate_camera_report import number, report_page

# How many pictures are searched for a board of another size once the one asked for is nowhere.
_SEARCHED_FOR_OTHERS = 3


@dataclass(frozen=True, eq=False)
class CameraJob:
    """All results of the command.

    Attributes:
        calibration: the fit to all usable views, which is written.
        unseen: names of the images in which the board was not found.
        crowded: names of views in which the refinement window reached beyond its corner.
        variants: other fits to compare with, by what was changed: without the poor views, with an adapted window.

    """

    calibration: CameraCalibration
    unseen: tuple[str, ...]
    crowded: tuple[str, ...]
    variants: dict[str, CameraCalibration]


def calibrate_camera_command(
    images: Annotated[
        list[Path], typer.Argument(metavar="IMAGES...", help="Photographs of the board: files, folders or patterns.")
    ],
    square_mm: Annotated[float, typer.Option("--square-mm", help="Side of one square of the board, mm.")],
    out: Annotated[Path, typer.Option("--out", help="Camera file: .yaml (ROS camera_info) or .yml (OpenCV).")],
    board: Annotated[
        str, typer.Option("--board", help="Inner corners, columns x rows: 9x6 is a board of 10x7 squares.")
    ] = "9x6",
    report: Annotated[
        Path | None, typer.Option("--report", help="Also write an interactive page, one file that opens offline.")
    ] = None,
    reference: Annotated[
        str | None,
        typer.Option(
            "--reference", help="Image whose board gives the camera's pose, by file name; default: the first."
        ),
    ] = None,
    window_px: Annotated[
        int,
        typer.Option(
            "--window-px",
            min=0,
            max=50,
            help=f"Half window of the sub-pixel refinement. {USUAL_WINDOW_PX} is usual and compares with published "
            "calibrations; 0 adapts it to each view, better where squares are small in the picture.",
        ),
    ] = USUAL_WINDOW_PX,
) -> None:
    """Calibrate a camera from photographs of a chessboard.

    Reports the error of each view, the uncertainty, how much of the image is covered, and which views to drop or add.

    Example: armtwin calibrate-camera views/*.jpg --board 9x6 --square-mm 25 --out camera.yaml --report camera.html
    """
    _check_outputs(out, report)
    job = calibrate_images(find_images(images), Board.parse(board, square_mm), reference, window_px)
    page = report_page(job.calibration, job.variants, advice_lines(job)) if report else ""
    write_camera(out, job.calibration.camera, name=out.stem, comment=_comment(job.calibration))
    if report:
        write_text(report, page)
    _print(Console(), job)
    typer.echo(f"Camera written to {out}" + (f", report to {report}" if report else ""))


def calibrate_images(paths: list[Path], board: Board, reference: str | None = None, window_px: int = 0) -> CameraJob:
    """Calibrate from image files; `window_px` 0 adapts the refinement window to each view.

    Raises:
        InputError: an image is corrupt or of another size, fewer than three show the board, or they are too much alike.

    """
    grays = dict(zip(_names(paths), read_views(paths), strict=True))
    if reference is not None and reference not in grays:
        raise InputError(f"--reference: found {reference!r}, wanted one of the images{nearest(reference, grays)}")
    views = _views(grays, board, window_px)
    unseen = tuple(name for name in grays if name not in {view.name for view in views})
    if len(views) < MIN_VIEWS:
        raise InputError(_too_few(views, grays, board))
    height, width = next(iter(grays.values())).shape
    names = [view.name for view in views]
    wanted = reference or names[0]
    if wanted not in names:
        raise InputError(f"{wanted}: found no board of {board}, wanted it in the reference view; name another one")
    fit = calibrate_camera(views, board, (width, height), names.index(wanted))
    grids = {view.name: view.pixels.reshape(board.rows, board.columns, 2) for view in views}
    crowded = tuple(name for name, grid in grids.items() if window_px > window_limit_px(grid))
    variants = {}
    if fit.advice.drop:
        kept = [view for view in views if view.name not in fit.advice.drop]
        at = [view.name for view in kept].index(wanted) if wanted not in fit.advice.drop else 0
        variants["poor views dropped"] = calibrate_camera(kept, board, (width, height), at)
    if crowded:
        again = _views({name: grays[name] for name in names}, board, 0)
        variants["--window-px 0"] = calibrate_camera(again, board, (width, height), names.index(wanted))
    return CameraJob(fit, unseen, crowded, variants)


def _views(grays: dict[str, Gray], board: Board, window_px: int) -> list[Corners]:
    views = []
    console = Console(stderr=True)
    bar = track(grays.items(), "Finding corners", console=console, transient=True, disable=not console.is_terminal)
    for name, gray in bar:
        pixels = find_corners(gray, board, window_px or None)
        if pixels is not None:
            views.append(Corners(name, pixels))
    return views


def _names(paths: list[Path]) -> list[str]:
    """File names, or whole paths where two folders hold the same file name."""
    count = Counter(path.name for path in paths)
    return [path.name if count[path.name] == 1 else path.as_posix() for path in paths]


def _too_few(views: list[Corners], grays: dict[str, Gray], board: Board) -> str:
    seen = f"found {board} in {len(views)} of {len(grays)} images"
    other = None if views else _other_board(list(grays.values())[:_SEARCHED_FOR_OTHERS], board)
    if other:
        return (
            f"--board: {seen}, but {other} are there; wanted the count of inner corners, "
            f"try --board {other.columns}x{other.rows}"
        )
    unseen = sorted(set(grays) - {view.name for view in views})
    advice = (
        f"not in {', '.join(unseen[:3])}{', …' if len(unseen) > 3 else ''}: show the whole board with its white "
        "margin, sharp and evenly lit, and check --board (inner corners)"
        if unseen
        else "photograph the board from more sides"
    )
    return f"camera calibration: {seen}, wanted at least {MIN_VIEWS}; {advice}"


def _other_board(grays: list[Gray], board: Board) -> Board | None:
    """A board of nearly the size asked for that the pictures do show: squares were counted, or one miscounted."""
    around = [(dx, dy) for dx in (-1, 0, 1) for dy in (-1, 0, 1) if (dx, dy) != (0, 0)]
    for dx, dy in around:
        columns, rows = board.columns + dx, board.rows + dy
        if min(columns, rows) < MIN_CORNERS:
            continue
        other = Board(columns, rows, board.square_mm)
        if any(find_corners(gray, other, thorough=False) is not None for gray in grays):
            return other
    return None


def _check_outputs(out: Path, report: Path | None) -> None:
    """Refuse what cannot be written before any work is done."""
    if out.suffix not in (".yaml", ".yml"):
        raise InputError(
            f"--out {out}: found the suffix {out.suffix!r}, wanted .yaml (ROS camera_info) or .yml (OpenCV)"
        )
    if report is not None and report.suffix not in (".html", ".htm"):
        raise InputError(f"--report {report}: found the suffix {report.suffix!r}, wanted .html")
    for option, path in (("--out", out), ("--report", report)):
        if path is not None and path.is_dir():
            raise InputError(f"{option} {path}: found a folder, wanted a file")
        blocking = next((p for p in path.absolute().parents if p.exists() and not p.is_dir()), None) if path else None
        if blocking:
            raise InputError(f"{option} {path}: found a file where the folder {blocking} is wanted")


def _comment(fit: CameraCalibration) -> str:
    lines = [
        f"Calibrated by armtwin from {len(fit.views)} views of a chessboard: {fit.board}, squares of "
        f"{fit.board.square_mm:g} mm; RMS {fit.rms_px:.4f} px.",
        f"The pose is that of the board in {fit.views[fit.reference].name}: X_camera = R X_board + t.",
        "Standard deviations (independent corners; from leaving out views):",
        *(f"  {name}: {fit.std[name]:.3g}; {number(fit.jackknife_std[name], '.3g')}" for name in INTRINSICS),
    ]
    return "\n".join(lines)


def _print(console: Console, job: CameraJob) -> None:
    fit = job.calibration
    console.print(f"{len(fit.views)} views of {fit.board}, RMS [bold]{fit.rms_px:.3f} px[/bold]")
    console.print(_parameter_table(job))
    console.print(_view_table(job))
    coverage = fit.coverage
    console.print(
        f"Coverage: corners span {coverage.hull_share:.0%} of the image and reach {coverage.reach_share:.0%} "
        "of the way to its corners"
    )
    for line in advice_lines(job):
        console.print(Text("→ " + line))


def _parameter_table(job: CameraJob) -> Table:
    fit = job.calibration
    table = Table("", "value", "± (std)", "± (views)", *job.variants, box=None, pad_edge=False)
    for column in table.columns[1:]:
        column.justify = "right"
    for name in INTRINSICS:
        digits = 2 if name[0] in "fc" else 5
        cells = [fit.intrinsics[name], fit.std[name], fit.jackknife_std[name]]
        cells += [variant.intrinsics[name] for variant in job.variants.values()]
        unit = " px" if name[0] in "fc" else ""
        table.add_row(name + unit, *(number(cell, f".{digits}f") for cell in cells))
    table.add_row(
        "RMS px", f"{fit.rms_px:.3f}", "", "", *(f"{variant.rms_px:.3f}" for variant in job.variants.values())
    )
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
            "corners close together" if view.name in job.crowded else "",
            "reference" if i == fit.reference else "",
        ]
        change = fit.uncertainty.without_view[i, 0]
        style = "bold red" if view.name in fit.advice.drop else None
        cells = [f"{fit.per_view_rms_px[i]:.3f}", f"{tilt_deg[i]:.0f}", f"{change:+.2f} px"]
        table.add_row(Text(view.name), *cells, ", ".join(note for note in notes if note), style=style)
    for name in job.unseen:
        table.add_row(Text(name), "-", "-", "-", "board not found", style="yellow")
    return table


def advice_lines(job: CameraJob) -> list[str]:
    """Say what would make the calibration better, one line each."""
    fit = job.calibration
    lines = []
    if job.crowded:
        lines.append(
            f"rerun with --window-px 0: in {', '.join(job.crowded)} the refinement window sees more than one corner"
        )
    rms = dict(zip((view.name for view in fit.views), fit.per_view_rms_px, strict=True))
    median = float(np.median(fit.per_view_rms_px))
    lines += [
        f"drop {name}: {rms[name]:.2f} px where half of the views have {median:.2f} px or less"
        for name in fit.advice.drop
    ]
    if job.unseen:
        lines.append(f"retake or leave out, the whole board was not found: {', '.join(job.unseen)}")
    lines += [f"add {what}" for what in fit.advice.add]
    return lines or ["nothing to drop or add"]
