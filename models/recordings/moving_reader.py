"""Reading recordings of moving arms; every breach of the contract is one line with file, row and column."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from armtwin.models.arm import Arm, arm_from_table
from armtwin.models.csv_table import in_units, read_csv
from armtwin.models.errors import InputError, RecordingError, shown
from armtwin.models.recordings.moving import ModelArm, MovingRecording
from armtwin.models.recordings.moving_checks import check_motions
from armtwin.models.recordings.table import Table
from armtwin.models.validation import FROM_LIST, HEAVIEST_KG, ArmTable, CameraTable, Finite, Strict, check

Array = NDArray[np.float64]

_MAX_JSON_BYTES = 1 << 20
# A million rows of six joints; see MOST_ROWS of the importers.
_MAX_CSV_BYTES = 1 << 29
_MAX_MODEL_BYTES = 1 << 24
_MOST_JOINTS = 7
# Columns of each joint, and of the row, beside commands and angles.
JOINT_EXTRAS = ("torque_nm", "current_a", "vel_rad_s")
_ROW_EXTRAS = ("commanded_s", "payload_kg", "temperature_c", "supply_v")
_COLDEST_C, _HOTTEST_C = -100.0, 200.0
_Name = Annotated[str, Field(min_length=1, max_length=200)]
_Registers = Annotated[list[Finite | None], Field(max_length=_MOST_JOINTS)]


class _ModelTable(Strict):
    name: Annotated[str, Field(min_length=1, max_length=100)]
    model: _Name
    joints: Annotated[list[_Name], Field(min_length=1, max_length=_MOST_JOINTS)]


class _ServoTable(Strict):
    p_gain: _Registers | None = None
    i_gain: _Registers | None = None
    d_gain: _Registers | None = None
    dead_zone_counts: _Registers | None = None
    counts_per_turn: _Registers | None = None
    minimum_startup_force: _Registers | None = None
    acceleration: _Registers | None = None


class _SettingsTable(Strict):
    servo: _ServoTable | None = None
    payload_kg: Annotated[float, Field(ge=0.0, le=HEAVIEST_KG)] | None = None


class _Header(Strict):
    schema_: Literal["armtwin.recording/1"] = Field(alias="schema")
    motion: Literal["moving"]
    clock: Literal["measured", "synthetic"] = "measured"
    servo: _ServoTable | None = None
    trajectories: Annotated[dict[_Name, _SettingsTable], Field(max_length=1000)] = Field(default_factory=dict)
    held_out: Annotated[tuple[str, ...], Field(max_length=1000), FROM_LIST] = ()


class _LengthsFile(_Header):
    arm: ArmTable
    camera: CameraTable | None = None
    arm_plane_z_mm: Finite | None = None
    pixel_noise_px: Annotated[float, Field(gt=0.0, le=100.0)] | None = None


class _ModelFile(_Header):
    arm: _ModelTable


def is_moving(folder: Path) -> bool:
    """Tell whether a folder says that it holds a recording of a moving arm; what is wrong with it else is not asked."""
    path = folder / "recording.json"
    try:
        if not path.is_file() or path.stat().st_size > _MAX_JSON_BYTES:
            return False
        data = json.loads(path.read_text("utf-8-sig"))
    except (OSError, ValueError, RecursionError):
        return False
    return isinstance(data, dict) and data.get("motion") == "moving"


def read_moving(folder: Path) -> MovingRecording:
    """Read a recording of a moving arm; raises `RecordingError` that names the file, the key or row, and what to do."""
    try:
        return _read(folder)
    except RecordingError:
        raise
    except OSError as error:
        raise RecordingError(f"{folder}: cannot be read ({error.strerror})") from None
    except InputError as error:
        raise RecordingError(str(error)) from None


def _read(folder: Path) -> MovingRecording:
    header = _header(folder / "recording.json")
    arm: Arm | ModelArm
    if isinstance(header, _ModelFile):
        arm = _model_arm(folder, header.arm)
    else:
        arm = arm_from_table(header.arm)
        if header.camera is not None:
            raise RecordingError("recording.json: camera: a film; `armtwin measure` makes joint angles of it")
    n = arm.n_joints
    path = folder / "samples.csv"
    if not path.is_file():
        raise RecordingError(f"{path}: no such file; a recording folder needs it")
    cells = in_units(read_csv(path, _MAX_CSV_BYTES, "one row a sample"), _columns(n))
    for name in _wanted(n):
        if name not in cells.columns:
            raise RecordingError(f"samples.csv: column '{name}' is missing{_why(name)}")
    if len(cells) < 3:
        raise RecordingError(f"samples.csv: {len(cells)} rows; a motion is wanted")
    table = Table(cells)
    table.samples()
    extras = {
        ending: np.stack([table.numbers(f"theta{i + 1}_{ending}") for i in range(n)], axis=-1)
        for ending in JOINT_EXTRAS
        if f"theta1_{ending}" in cells.columns
    }
    if "supply_v" in cells.columns:
        extras["supply_v"] = table.numbers("supply_v")
    recording = MovingRecording(
        arm=arm,
        time_s=table.growing_times(),
        trajectory=table.names("trajectory"),
        q_cmd=table.joint_angles(n, "cmd", may_be_empty=False),
        q_meas=table.joint_angles(n, "meas", may_be_empty=True),
        commanded_s=table.numbers("commanded_s") if "commanded_s" in cells.columns else None,
        extras=extras,
        payload_kg=table.within("payload_kg", 0.0, HEAVIEST_KG) if "payload_kg" in cells.columns else None,
        temperature_c=table.within("temperature_c", _COLDEST_C, _HOTTEST_C)
        if "temperature_c" in cells.columns
        else None,
        clock=header.clock,
        servo=_registers(header.servo, n, "servo"),
        settings={name: _settings(one, n, name) for name, one in header.trajectories.items()},
        held_out=header.held_out,
        folder=folder,
    )
    check_motions(recording)
    return recording


def _header(path: Path) -> _LengthsFile | _ModelFile:
    if not path.is_file():
        raise RecordingError(f"{path}: no such file; a recording folder needs it")
    if path.stat().st_size > _MAX_JSON_BYTES:
        raise RecordingError(f"{path.name}: larger than {_MAX_JSON_BYTES} bytes, no header of a recording")
    try:
        data: Any = json.loads(path.read_text("utf-8-sig"))
    except (ValueError, RecursionError) as error:
        raise RecordingError(f"{path.name}: not JSON ({error})") from None
    arm = data.get("arm") if isinstance(data, dict) else None
    if isinstance(arm, dict) and "model" in arm:
        return check(_ModelFile, data, path.name)
    return check(_LengthsFile, data, path.name)


def _model_arm(folder: Path, table: _ModelTable) -> ModelArm:
    """Return the arm of a model inside the folder, whose joints are looked up when it is loaded."""
    if len(set(table.joints)) != len(table.joints):
        raise RecordingError("recording.json: arm.joints: a joint stands twice; name each once")
    path = folder / table.model
    inside = path.resolve().is_relative_to(folder.resolve())
    if not inside or Path(table.model).is_absolute():
        raise RecordingError(
            f"recording.json: arm.model: '{shown(table.model)}' lies outside the recording; copy it into the folder"
        )
    if path.suffix.lower() not in (".xml", ".urdf"):
        raise RecordingError(f"recording.json: arm.model: '{shown(table.model)}' is no .xml (MJCF) or .urdf file")
    if not path.is_file():
        raise RecordingError(f"recording.json: arm.model: there is no file '{shown(table.model)}' in the recording")
    if path.stat().st_size > _MAX_MODEL_BYTES:
        raise RecordingError(
            f"recording.json: arm.model: '{shown(table.model)}' is larger than {_MAX_MODEL_BYTES} bytes"
        )
    return ModelArm(table.name, tuple(table.joints), path)


def _registers(table: _ServoTable | None, n: int, key: str) -> dict[str, tuple[float | None, ...]]:
    stated = {} if table is None else {k: v for k, v in table.model_dump().items() if v is not None}
    for name, values in stated.items():
        if len(values) != n:
            raise RecordingError(
                f"recording.json: {key}.{name}: {len(values)} values, one for each of {n} joints is wanted"
            )
    return {name: tuple(values) for name, values in stated.items()}


def _settings(table: _SettingsTable, n: int, name: str) -> dict[str, object]:
    out: dict[str, object] = dict(_registers(table.servo, n, f"trajectories.{name}.servo"))
    if table.payload_kg is not None:
        out["payload_kg"] = table.payload_kg
    return out


def _wanted(n: int) -> list[str]:
    names = ["sample", "time_s", "trajectory"]
    return names + [f"theta{i + 1}_{kind}_rad" for kind in ("cmd", "meas") for i in range(n)]


def _columns(n: int) -> list[str]:
    return [*_wanted(n), *(f"theta{i + 1}_{ending}" for ending in JOINT_EXTRAS for i in range(n)), *_ROW_EXTRAS]


def _why(name: str) -> str:
    return "; a moving arm needs the time of every row" if name == "time_s" else ""
