"""`armtwin calibrate`: the built arm's lengths and joint zeros from a recording, and how well they are known."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import tomli_w
import typer
from rich.console import Console
from rich.table import Table
from rich.text import Text

from armtwin.calib.arm import algorithm_1, least_squares
from armtwin.calib.arm.calibration import ArmCalibration
from armtwin.calib.arm.evaluation import TipError, drawn_base_mm, joint_error_rms, tip_error
from armtwin.calib.arm.observations import rows_to_fit
from armtwin.calib.setup.screen import screen
from armtwin.models.arm import Arm
from armtwin.models.atomic import write_json, write_text
from armtwin.models.errors import InputError, nearest
from armtwin.models.recordings.reader import read_recording
from armtwin.models.recordings.recording import Recording
from armtwin.models.recordings.writer import arm_table
from armtwin.models.validation import ArmFile, check
from armtwin.scenarios.commands.outputs import only_results

SCHEMA = "armtwin.calibration/1"
# Over fifty poses the residuals give the noise to 4 %, and a stated one is rarely known better than to a tenth.
_MORE_THAN_NOISE = 1.3


class Method(StrEnum):
    """How the arm is calibrated."""

    LEAST_SQUARES = "least-squares"
    ALGORITHM_1 = "algorithm-1"


@dataclass(frozen=True)
class Comparison:
    """The tip's error on one group of poses with the drawing and with the calibrated arm; joint angles, rad, if not."""

    name: str
    held_out: bool
    before: TipError | None
    after: TipError | None
    joint_rms_before_rad: float
    joint_rms_after_rad: float


def calibrate_command(
    recording: Annotated[Path, typer.Argument(metavar="RECORDING", help="Folder with recording.json and samples.csv.")],
    out: Annotated[Path, typer.Option("--out", help="Folder for calibration.json and arm.toml.")],
    method: Annotated[
        Method, typer.Option("--method", help="least-squares on all markers, or the paper's Algorithm 1 on A and F.")
    ] = Method.LEAST_SQUARES,
    hold_out: Annotated[
        list[str] | None,
        typer.Option("--hold-out", help="Trajectory to validate on; repeatable. Default: what the recording names."),
    ] = None,
    mend: Annotated[
        bool, typer.Option("--mend", help="Calibrate the recording without the gross errors of its set-up.")
    ] = False,
) -> None:
    """Calibrate the arm of a recording: link lengths and joint zeros, with what can and cannot be known.

    Writes calibration.json (estimates with standard deviations and 95 % intervals, identifiability, error before and
    after) and arm.toml (the arm with its calibrated lengths; the joint zeros stand in calibration.json).

    Example: armtwin calibrate out/paper/recordings/before --out calibrated --hold-out line
    """
    with only_results(out):
        _calibrate(recording, out, method, hold_out, mend)


def _calibrate(recording: Path, out: Path, method: Method, hold_out: list[str] | None, mend: bool) -> None:
    data = _set_up_right(_with_held_out(read_recording(recording), hold_out), mend)
    found = least_squares.calibrate(data) if method is Method.LEAST_SQUARES else algorithm_1.calibrate(data)
    comparisons = compare(data, found)
    arm_text = corrected_arm_text(data.arm, found)
    write_text(out / "arm.toml", arm_text)
    write_json(out / "calibration.json", calibration_table(data, found, comparisons))
    _print(Console(), data, found, comparisons)
    typer.echo(f"Calibration written to {out / 'calibration.json'}, arm to {out / 'arm.toml'}")


def _set_up_right(recording: Recording, mend: bool) -> Recording:
    """Return the recording mended of gross errors of its set-up; raises `InputError` for them unless it may `mend`."""
    screened = screen(recording)
    for line in screened.sentences:
        if not mend:
            raise InputError(f"{line}; or calibrate with --mend, as if that were done")
        typer.echo(f"Mended: {line}")
    return screened.recording


def compare(recording: Recording, found: ArmCalibration) -> list[Comparison]:
    """Compare drawing and calibrated arm on the poses fitted, and on each held-out trajectory."""
    groups = [("fitted", False, rows_to_fit(recording))]
    groups += [(name, True, np.flatnonzero(recording.trajectory == name)) for name in recording.held_out]
    tip = recording.arm.marker_names[-1]
    comparisons = []
    for name, held_out, rows in groups:
        seen = tip in recording.markers_px and bool(np.isfinite(recording.markers_px[tip][rows]).all(axis=-1).any())
        base = found.base_in_board_mm if seen else None
        comparisons.append(
            Comparison(
                name=name,
                held_out=held_out,
                before=None if base is None else tip_error(recording, rows, drawn_base_mm(recording)),
                after=None if base is None else tip_error(recording, rows, base, found.deviation),
                joint_rms_before_rad=joint_error_rms(recording, rows),
                joint_rms_after_rad=joint_error_rms(recording, rows, found.deviation),
            )
        )
    return comparisons


def calibration_table(recording: Recording, found: ArmCalibration, comparisons: list[Comparison]) -> dict[str, Any]:
    """Return the content of `calibration.json` (`armtwin.calibration/1`)."""
    return {
        "schema": SCHEMA,
        "arm": arm_table(recording.arm),
        **found.as_table(),
        "errors": [asdict(comparison) for comparison in comparisons],
    }


def corrected_arm_text(arm: Arm, found: ArmCalibration) -> str:
    """Return an arm file with the calibrated lengths; raises `InputError` for lengths that no arm has."""
    corrected = replace(arm, link_lengths_mm=arm.link_lengths_mm + found.deviation.lengths_mm)
    table = {"schema": "armtwin.arm/1", **arm_table(corrected)}
    check(ArmFile, table, "calibrated arm")
    return f"# Lengths calibrated by {found.method}; the joint zeros stand in calibration.json.\n" + tomli_w.dumps(
        table
    )


def _with_held_out(recording: Recording, hold_out: list[str] | None) -> Recording:
    if not hold_out:
        return recording
    present = {str(name) for name in recording.trajectory}
    for name in hold_out:
        if name not in present:
            raise InputError(f"--hold-out: samples.csv has no trajectory '{name}'{nearest(name, present)}")
    return replace(recording, held_out=tuple(dict.fromkeys(hold_out)))


def _known(found: ArmCalibration) -> str:
    links = len(found.deviation.lengths_mm) + len(found.deviation.joints_rad)
    return f"{found.identifiable} of {links} link parameters can be known"


def _warnings(recording: Recording, found: ArmCalibration) -> list[str]:
    """Say so where the residuals are larger than the recording's own noise: the deviations then assume too much."""
    stated = recording.pixel_noise_px
    if stated is None or not np.isfinite(found.rms_px) or found.noise < _MORE_THAN_NOISE * stated:
        return []
    return [
        f"the residuals show {found.noise:.3g} px of noise, the recording states {stated:.3g} px: something moves that "
        "the geometry does not explain (play, sag, ...); std takes all errors for independent, clustered_std in "
        "calibration.json does not; armtwin diagnose looks for the cause"
    ]


def _print(console: Console, recording: Recording, found: ArmCalibration, comparisons: list[Comparison]) -> None:
    table = Table(title=f"Arm calibration, {found.method}, {found.n_poses} poses")
    for heading in ("parameter", "value", "std", "95 % interval"):
        table.add_column(heading, justify="left" if heading == "parameter" else "right")
    intervals = found.intervals95
    for name, value, std, (low, high) in zip(found.names, found.values, found.std, intervals, strict=True):
        # Angles are shown in degrees, as in the paper's Table 4.
        label, factor = (name[: -len("_rad")] + "_deg", 180.0 / np.pi) if name.endswith("_rad") else (name, 1.0)
        cells = [value, std, low, high]
        v, s, a, b = (f"{cell * factor:.4f}" if np.isfinite(cell) else "not given" for cell in cells)
        table.add_row(label, v, s, f"{a} to {b}" if np.isfinite(low) else "not given")
    console.print(table)
    for line in (_known(found), *found.gauge, *found.ties, *_warnings(recording, found)):
        console.print(Text(line))
    if found.outliers:
        places = ", ".join(f"{outlier.marker} of sample {outlier.sample}" for outlier in found.outliers[:5])
        console.print(Text(f"{len(found.outliers)} measurements left out as outliers: {places}"))
    errors = Table(title="Mean error of the tip, mm")
    for heading in ("poses", "drawing", "calibrated"):
        errors.add_column(heading, justify="left" if heading == "poses" else "right")
    for row in comparisons:
        if row.before is not None and row.after is not None:
            label = f"{row.name} (held out)" if row.held_out else row.name
            errors.add_row(Text(label), f"{row.before.mean_mm:.3f}", f"{row.after.mean_mm:.3f}")
    if errors.row_count:
        console.print(errors)
