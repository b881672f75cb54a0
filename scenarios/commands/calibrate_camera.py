"""`armtwin calibrate-camera`: a camera file from photographs of a board, with how far to trust it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from armtwin.calib.camera.board import Board
from armtwin.calib.camera.charuco import CharucoTarget
from armtwin.calib.camera.circles import CircleGrid
from armtwin.calib.camera.corners import USUAL_WINDOW_PX
from armtwin.calib.camera.images import find_images
from armtwin.calib.camera.target import Target
from armtwin.models.atomic import write_text
from armtwin.models.camera_files import read_camera, write_camera
from armtwin.models.errors import InputError, nearest
from armtwin.scenarios.camera_calibration.job import AUTOMATIC, calibrate_views, check_model, collect
from armtwin.scenarios.camera_calibration.page import report_page
from armtwin.scenarios.camera_calibration.pose import place_camera
from armtwin.scenarios.camera_calibration.words import comment, tell, tell_pose

_TARGETS = ("chessboard", "charuco", "circles", "staggered-circles")


def calibrate_camera_command(
    images: Annotated[
        list[Path],
        typer.Argument(metavar="PHOTOS...", help="Photographs or videos of the board: files, folders or patterns."),
    ],
    square_mm: Annotated[
        float, typer.Option("--square-mm", help="Side of one square, or distance of two rows of circles, mm.")
    ],
    out: Annotated[Path, typer.Option("--out", help="Camera file: .yaml (ROS camera_info) or .yml (OpenCV).")],
    board: Annotated[
        str,
        typer.Option(
            "--board",
            help="Columns x rows: inner corners of a chessboard (9x6 is a board of 10x7 squares), squares of a ChArUco "
            "board, circles.",
        ),
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
            help="Half window of the sub-pixel refinement; 0 takes the largest that sees one corner only. "
            f"{USUAL_WINDOW_PX} for all views compares with published calibrations.",
        ),
    ] = 0,
    target: Annotated[str, typer.Option("--target", help=f"What was photographed: {', '.join(_TARGETS)}.")] = _TARGETS[
        0
    ],
    dictionary: Annotated[
        str, typer.Option("--dictionary", help="Markers of a ChArUco board, such as 4x4_50 or 5x5_100.")
    ] = "4x4_50",
    marker_mm: Annotated[
        float | None,
        typer.Option("--marker-mm", help="Side of a ChArUco board's markers, mm; default: three quarters of a square."),
    ] = None,
    model: Annotated[
        str,
        typer.Option(
            "--model",
            help="Lens to fit: auto (what predicts left-out views best), plumb_bob, plumb_bob_centred, "
            "plumb_bob_bowed_board, equidistant, rational, thin_prism.",
        ),
    ] = AUTOMATIC,
    intrinsics: Annotated[
        Path | None,
        typer.Option("--intrinsics", help="Keep this camera file's intrinsics; take the pose from one photograph."),
    ] = None,
) -> None:
    """Calibrate a camera from photographs of a board.

    Reports the error of each view, the uncertainty, how well other lenses would do, how much of the image is covered,
    and which views to drop or add.

    Example: armtwin calibrate-camera out/paper/board/*.png --square-mm 23 --out camera.yaml --report camera.html
    """
    _check_outputs(out, report)
    check_model(model)
    what = _target(target, board, square_mm, dictionary, marker_mm)
    known = None if intrinsics is None else read_camera(intrinsics)
    if known is not None and report is not None:
        raise InputError("--report: found it beside --intrinsics, wanted one of them; a pose alone has no page")
    found = find_images(images)
    seen = collect(found, what, window_px)
    if known is not None:
        placed = place_camera(known, seen, reference)
        says = f"Intrinsics of {intrinsics}, kept; pose of the board in {placed.name}, RMS {placed.rms_px:.4f} px."
        write_camera(out, placed.camera, name=out.stem, comment=says)
        tell_pose(Console(), placed)
        typer.echo(f"Camera written to {out}")
        return
    job = calibrate_views(seen, found, reference, model)
    page = report_page(job) if report else ""
    write_camera(out, job.calibration.camera, name=out.stem, comment=comment(job.calibration))
    if report:
        write_text(report, page)
    tell(Console(), job)
    typer.echo(f"Camera written to {out}" + (f", report to {report}" if report else ""))


def _target(kind: str, board: str, square_mm: float, dictionary: str, marker_mm: float | None) -> Target:
    if kind == "chessboard":
        return Board.parse(board, square_mm)
    if kind == "charuco":
        return CharucoTarget.parse(board, square_mm, dictionary, marker_mm)
    if kind in _TARGETS:
        return CircleGrid.parse(board, square_mm, staggered=kind == "staggered-circles")
    raise InputError(f"--target: found {kind!r}, wanted one of {', '.join(_TARGETS)}{nearest(kind, _TARGETS)}")


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
