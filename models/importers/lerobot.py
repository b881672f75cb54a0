"""LeRobot data sets, v2.1 and v3: `observation.state` beside `action`, one episode a trajectory.

A row's observation is read before its action is sent, so the action is the command in force from that row on. Its
`timestamp` is frame_index / fps, no clock. No unit is stored: SO arms are in degrees since February 2026, before that
in -100 to 100 of each joint's calibrated range, a gripper in 0 to 100; so the unit has to be said.
"""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from armtwin.models.errors import InputError, JobError, shown
from armtwin.models.importers.log import MOST_ROWS, JointLog, checked

Array = NDArray[np.float64]
Unit = Literal["deg", "range", "counts"]

_VERSIONS = ("v2.0", "v2.1", "v3.0")
_MAX_JSON_BYTES = 1 << 24
# Feetech's and Dynamixel's encoders; LeRobot spreads 360 degrees over 4095 counts, a real turn has 4096.
_COUNTS = 4096.0
_LEROBOT_DEG_PER_COUNT = 360.0 / 4095.0
# Readings of a lattice lie this near to whole counts, in counts.
_ON_LATTICE = 0.1


def read_lerobot(
    folder: Path, unit: Unit | None, calibration: Path | None = None, episodes: Sequence[int] | None = None
) -> JointLog:
    """Read a data set's folder; `calibration` is the robot's file (`id`, `homing_offset`, `range_min`, ...).

    Raises `InputError` for what it cannot hold, `JobError` where pyarrow is not installed.
    """
    info = _json(folder / "meta" / "info.json", folder)
    version = str(info.get("codebase_version"))
    if version not in _VERSIONS:
        raise InputError(f"info.json: codebase_version: found '{shown(version)}', {', '.join(_VERSIONS)} can be read")
    if unit is None:
        raise InputError(
            "--unit: a LeRobot data set stores none; say deg (SO arms since February 2026), range (-100 to 100, before "
            "that) or counts"
        )
    joints, picked = _names(info)
    table = _rows(folder, info, episodes)
    state, action = table["observation.state"], table["action"]
    if state.shape[1] != len(joints) or action.shape[1] != len(picked):
        raise InputError(f"info.json: names {len(joints)} joints, the rows hold {state.shape[1]}")
    action = action[:, picked]
    gripper = [name for name in joints if "gripper" in name]
    keep = [k for k, name in enumerate(joints) if name not in gripper]
    notes = [f"LeRobot {version}: {len(np.unique(table['episode_index']))} episodes, each a trajectory"]
    if gripper:
        notes.append(f"left out: {', '.join(gripper)} (opens in per cent, not in an angle)")
    q_meas, q_cmd = np.empty((len(state), len(keep))), np.empty((len(state), len(keep)))
    ranges = None if calibration is None else _json(calibration, calibration)
    for column, k in enumerate(keep):
        scale, shift, how = _to_radians(unit, joints[k], state[:, k], ranges)
        q_meas[:, column], q_cmd[:, column] = scale * (state[:, k] - shift), scale * (action[:, k] - shift)
        notes.append(f"{joints[k]}: {how}")
    notes.append("zero is the middle of each joint's range, not the zero of a URDF")
    notes.append(f"times are row numbers over {info.get('fps')} Hz, no clock: delays are as true as that rate")
    return checked(
        JointLog(
            joints=tuple(joints[k] for k in keep),
            time_s=table["timestamp"],
            trajectory=np.array([f"episode_{int(number):06d}" for number in table["episode_index"]], dtype=np.str_),
            q_cmd=q_cmd,
            q_meas=q_meas,
            clock="synthetic",
            notes=tuple(notes),
        ),
        folder.name,
    )


def lattice_step(values: Array) -> float | None:
    """Return the step of the lattice that readings lie on, or None where they lie on none."""
    levels = np.unique(np.round(values, 6))
    gaps = np.diff(levels)
    if len(gaps) < 10:
        return None
    step = float(np.percentile(gaps, 5))
    for _ in range(5):  # from the smallest gaps to all of them
        near = gaps[gaps < 20 * step]
        whole = np.maximum(np.round(near / step), 1.0)
        step = float((near @ whole) / (whole @ whole))
    off = np.abs(near / step - whole)
    return step if float(np.percentile(off, 90)) < _ON_LATTICE else None


def _to_radians(unit: Unit, joint: str, state: Array, ranges: dict[str, Any] | None) -> tuple[float, float, str]:
    """Return scale and zero of q = scale (value - zero), and how they were found."""
    if unit == "deg":
        return np.pi / 180.0, 0.0, "degrees"
    if ranges is not None:
        low, high, sign = _range(ranges, joint)
        middle, rad_per_count = (low + high) / 2.0, np.radians(_LEROBOT_DEG_PER_COUNT)
        if unit == "counts":
            return sign * rad_per_count, middle, f"counts, middle {middle:g} of the calibration file"
        return sign * rad_per_count * (high - low) / 200.0, 0.0, f"-100 to 100 of {high - low:g} counts, by the file"
    if unit == "counts":
        raise InputError(f"--calibration: counts of '{shown(joint)}' have no zero without the robot's calibration file")
    step = lattice_step(state)
    if step is None:
        raise InputError(f"--calibration: the range of '{shown(joint)}' cannot be told from the readings; give it")
    return 2.0 * np.pi / _COUNTS / step, 0.0, f"-100 to 100 of {200.0 / step:.0f} counts, told by the readings' steps"


def _range(ranges: dict[str, Any], joint: str) -> tuple[float, float, float]:
    entry: Any = ranges.get(joint)
    values: list[Any] = [entry.get(key) for key in ("range_min", "range_max")] if isinstance(entry, dict) else []
    numbers = len(values) == 2 and all(isinstance(value, int | float) and abs(value) < 1e6 for value in values)
    if not numbers or not values[1] > values[0]:
        raise InputError(f"calibration: '{shown(joint)}': range_min below range_max is wanted, as LeRobot writes them")
    return float(values[0]), float(values[1]), -1.0 if entry.get("drive_mode") else 1.0


def _names(info: dict[str, Any]) -> tuple[list[str], list[int]]:
    """Return the joints of the state, and where each stands in the action."""
    features = info.get("features")
    if not isinstance(features, dict):
        raise InputError("info.json: key 'features' is missing; a LeRobot data set has it")
    found = {}
    for key in ("observation.state", "action"):
        names = features.get(key, {}).get("names") if isinstance(features.get(key), dict) else None
        while isinstance(names, dict) and names:  # older ones: {"motors": [...]}
            names = next(iter(names.values()))
        if not isinstance(names, list) or not names or len(names) > 100:
            raise InputError(f"info.json: features.{key} names no joints; an arm's log has state and action")
        found[key] = [str(name).removesuffix(".pos") for name in names]
    joints, actions = found["observation.state"], found["action"]
    missing = [name for name in joints if name not in actions]
    if missing:
        raise InputError(f"info.json: action has no '{shown(missing[0])}', which observation.state has")
    return joints, [actions.index(name) for name in joints]


def _rows(folder: Path, info: dict[str, Any], episodes: Sequence[int] | None) -> dict[str, Array]:
    try:
        import pyarrow
        from pyarrow import parquet
    except ModuleNotFoundError as error:
        raise JobError(f"{error.name} is not installed, which reads LeRobot's files; install armtwin[import]") from None
    pattern = re.sub(r"\{[^{}]*\}", "*", str(info.get("data_path", "")))
    if not pattern.endswith(".parquet") or ".." in Path(pattern).parts or Path(pattern).is_absolute():
        raise InputError(f"info.json: data_path: found '{shown(pattern)}', parquet files inside the folder are wanted")
    files = sorted(folder.glob(pattern))
    if not files:
        raise InputError(f"{folder}: no file {shown(pattern)}; is it a whole data set? (git lfs pull fetches the data)")
    wanted = ["observation.state", "action", "timestamp", "frame_index", "episode_index"]
    blocks: dict[str, list[Array]] = {name: [] for name in wanted}
    rows = 0
    for file in files:
        try:
            metadata = parquet.read_metadata(file)
            rows += metadata.num_rows
            if rows > MOST_ROWS:
                raise InputError(f"{folder.name}: more than {MOST_ROWS} rows; choose with --episodes")
            table = parquet.read_table(file, columns=wanted)
            for name in wanted:
                column = table.column(name).combine_chunks()
                values = np.array(column.to_pylist(), dtype=float)
                blocks[name].append(values)
        except (pyarrow.ArrowException, KeyError, ValueError, OSError) as error:
            reason = str(error).splitlines()[0][:120]
            raise InputError(f"{file.relative_to(folder)}: cannot be read as LeRobot's ({shown(reason)})") from None
    out = {name: np.concatenate(block) for name, block in blocks.items()}
    keep = np.ones(len(out["timestamp"]), dtype=bool)
    if episodes is not None:
        keep = np.isin(out["episode_index"], list(episodes))
        if not keep.any():
            raise InputError(f"--episodes: there are {sorted(map(int, set(out['episode_index'])))[:20]}")
    order = np.lexsort((out["frame_index"], out["episode_index"]))
    order = order[keep[order]]
    return {name: values[order] for name, values in out.items()}


def _json(path: Path, folder: Path) -> dict[str, Any]:
    if not path.is_file():
        raise InputError(f"{folder}: has no {path.name}; a LeRobot data set's folder holds meta/info.json")
    if path.stat().st_size > _MAX_JSON_BYTES:
        raise InputError(f"{path.name}: larger than {_MAX_JSON_BYTES} bytes")
    try:
        value = json.loads(path.read_text("utf-8"))
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path.name}: not JSON ({error})") from None
    if not isinstance(value, dict):
        raise InputError(f"{path.name}: a table of keys is wanted")
    return value
