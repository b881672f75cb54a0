"""Reading recordings; every breach of the contract is one line with file, row and column."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from armtwin.models.arm import Arm, arm_from_table
from armtwin.models.camera import Camera, check_plane
from armtwin.models.csv_table import CsvTable, in_units, read_csv
from armtwin.models.errors import InputError, RecordingError, nearest, shown
from armtwin.models.lenses import lens_named
from armtwin.models.recordings.recording import OPTIONAL_COLUMNS, Recording
from armtwin.models.recordings.table import Table
from armtwin.models.validation import FROM_LIST, HEAVIEST_KG, ArmTable, CameraTable, Finite, Strict, check

Array = NDArray[np.float64]

# A recording of a million poses is about 200 MB; more is no recording of this arm.
_MAX_JSON_BYTES = 1 << 20
_MAX_CSV_BYTES = 1 << 28
# No detector finds a marker's centre better than to a millionth of a pixel, or is worth its name beyond a hundred.
_LEAST_NOISE_PX = 1e-6
_MOST_NOISE_PX = 100.0
# Beyond these no servo works.
_COLDEST_C = -100.0
_HOTTEST_C = 200.0


class _RecordingFile(Strict):
    schema_: Literal["armtwin.recording/1"] = Field(alias="schema")
    arm: ArmTable
    camera: CameraTable | None = None
    arm_plane_z_mm: Finite | None = None
    pixel_noise_px: Annotated[float, Field(ge=_LEAST_NOISE_PX, le=_MOST_NOISE_PX)] | None = None
    held_out: Annotated[tuple[str, ...], Field(max_length=1000), FROM_LIST] = ()


def read_recording(folder: Path, *, unmeasured: bool = False, film: bool = False) -> Recording:
    """Read a recording folder; raises `RecordingError` that names the file, the key or row, and what to do.

    `unmeasured` accepts one with neither markers nor measured angles: its frames are still to be measured. `film`
    accepts pictures of a moving arm, a row a picture.
    """
    if not folder.is_dir():
        raise RecordingError(f"{folder}: no such folder; a recording is a folder with recording.json and samples.csv")
    header = _read_header(folder / "recording.json", film)
    arm = arm_from_table(header.arm)
    cells = _read_cells(folder / "samples.csv", arm)
    columns = cells.columns
    table = Table(cells)
    markers = {name: table.pixels(name, header.camera) for name in arm.known_markers if f"{name}_u_px" in columns}
    q_meas = table.angles(arm, "meas", may_be_empty=True) if "theta1_meas_rad" in columns else None
    if not markers and q_meas is None and not unmeasured:
        raise RecordingError(
            "samples.csv: neither markers (a_u_px, ...) nor measured angles (theta1_meas_rad, ...); "
            "`armtwin measure` finds the markers in frames/"
        )
    if markers and (header.camera is None or header.arm_plane_z_mm is None):
        missing = "camera" if header.camera is None else "arm_plane_z_mm"
        raise RecordingError(f"recording.json: key '{missing}' is missing, samples.csv has markers in pixels")
    camera = None if header.camera is None else camera_from_table(header.camera)
    if camera is not None and header.arm_plane_z_mm is not None:
        try:
            check_plane(camera, header.arm_plane_z_mm)
        except InputError as error:
            raise RecordingError(f"recording.json: {error}") from None
    trajectory = table.names("trajectory")
    for name in header.held_out:
        if name not in trajectory:
            raise RecordingError(
                f"recording.json: held_out names trajectory '{shown(name)}', which samples.csv does not have"
                + nearest(name, {str(t) for t in trajectory})
            )
    return Recording(
        arm=arm,
        camera=camera,
        arm_plane_z_mm=header.arm_plane_z_mm,
        pixel_noise_px=header.pixel_noise_px,
        held_out=header.held_out,
        sample=table.samples(),
        time_s=table.times(),
        commanded_s=table.command_times() if "commanded_s" in columns else None,
        trajectory=trajectory,
        q_cmd=table.angles(arm, "cmd", may_be_empty=False),
        markers_px=markers,
        q_meas=q_meas,
        payload_kg=table.within("payload_kg", 0.0, HEAVIEST_KG) if "payload_kg" in columns else None,
        temperature_c=table.within("temperature_c", _COLDEST_C, _HOTTEST_C) if "temperature_c" in columns else None,
        folder=folder,
    )


def camera_from_table(table: CameraTable) -> Camera:
    """Return the camera of a validated table, its rotation made orthonormal (printed ones are rounded)."""
    U, _, Vt = np.linalg.svd(np.array(table.board_to_camera_rotation))
    R = np.array(table.board_to_camera_rotation)
    exact = np.abs(R @ R.T - np.eye(3)).max() < 1e-12
    return Camera(
        image_width=table.image_width,
        image_height=table.image_height,
        K=np.array(table.camera_matrix),
        lens=lens_named(table.distortion_model, table.distortion_coefficients),
        R_board_camera=R if exact else U @ Vt,
        t_board_camera_mm=np.array(table.board_to_camera_translation_mm),
    )


def _read_header(path: Path, film: bool) -> _RecordingFile:
    _check_is_file(path)
    try:
        if path.stat().st_size > _MAX_JSON_BYTES:
            raise RecordingError(f"{path.name}: larger than {_MAX_JSON_BYTES} bytes, no header of a recording")
        data = json.loads(path.read_text("utf-8-sig"))
    except OSError as error:
        raise RecordingError(f"{path}: cannot be read ({error.strerror}); a recording folder needs it") from None
    except (ValueError, RecursionError) as error:  # no JSON, no UTF-8, a whole number of thousands of digits
        raise RecordingError(f"{path.name}: not JSON ({error})") from None
    if isinstance(data, dict) and data.pop("motion", "settled") == "moving" and not film:
        raise RecordingError(f"{path.name}: motion: 'moving' found; poses at rest are wanted, not a moving arm's log")
    try:
        return check(_RecordingFile, data, path.name)
    except InputError as error:
        raise RecordingError(str(error)) from None


def _read_cells(path: Path, arm: Arm) -> CsvTable:
    _check_is_file(path)
    try:
        cells = in_units(read_csv(path, _MAX_CSV_BYTES, "one row a pose"), _valid_columns(arm))
    except OSError as error:
        raise RecordingError(f"{path}: cannot be read ({error.strerror}); a recording folder needs it") from None
    except InputError as error:
        raise RecordingError(str(error)) from None
    _check_columns(cells.columns, arm)
    return cells


def _check_is_file(path: Path) -> None:
    """Refuse what is no plain file: a pipe or a device would be read without end."""
    if not path.is_file():
        what = "no plain file" if path.exists() else "no such file"
        raise RecordingError(f"{path}: {what}; a recording folder needs it")


def _required_columns(arm: Arm) -> list[str]:
    return ["sample", "time_s", "trajectory", *(f"theta{i + 1}_cmd_rad" for i in range(arm.n_joints))]


def _measured_columns(arm: Arm) -> list[str]:
    return [f"theta{i + 1}_meas_rad" for i in range(arm.n_joints)]


def _valid_columns(arm: Arm) -> list[str]:
    pixels = [f"{name}_{axis}_px" for name in arm.known_markers for axis in "uv"]
    return [*_required_columns(arm), *pixels, *_measured_columns(arm), *OPTIONAL_COLUMNS]


def _check_columns(columns: list[str], arm: Arm) -> None:
    """Refuse a table that lacks a column."""
    measured = _measured_columns(arm)
    wanted = _required_columns(arm)
    for name in arm.known_markers:
        if f"{name}_u_px" in columns or f"{name}_v_px" in columns:
            wanted += [f"{name}_u_px", f"{name}_v_px"]
    if any(name in columns for name in measured):
        wanted += measured
    for name in wanted:
        if name not in columns:
            number = "; number the poses from 0, in the order in which they were taken" if name == "sample" else ""
            raise RecordingError(f"samples.csv: column '{name}' is missing{number}")
