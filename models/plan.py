"""Plans: the poses of a recording to be made, a CSV that the simulated, the emulated and the real bench execute."""

from __future__ import annotations

import csv
import io
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from armtwin.models import atomic
from armtwin.models.arm import Arm
from armtwin.models.errors import InputError, nearest, shown
from armtwin.models.kinematics import inverse
from armtwin.models.trajectories import paper_trajectories

Array = NDArray[np.float64]

_MAX_BYTES = 1 << 26
# Largest turn of a joint from pose to pose, rad, that a bench allows unless its file says otherwise.
MAX_STEP_RAD = 0.5
# More than a hobby servo of 1 N m holds on the shortest lever; a larger figure is in grams.
_MOST_PAYLOAD_KG = 5.0
# Commands are written with 17 digits; this forgives the last of them.
ROUNDING_RAD = 1e-9


@dataclass(frozen=True, eq=False)
class Plan:
    """(N,) trajectory names, (N, n) commands in rad, (N,) payload to hang at the tip in kg (0 where none)."""

    trajectory: NDArray[np.str_]
    q_cmd: Array
    payload_kg: Array

    def __len__(self) -> int:
        return len(self.q_cmd)


def paper_plan(arm: Arm) -> Plan:
    """Return the paper's three trajectories through the nominal inverse kinematics."""
    return plan_of({name: inverse(arm, poses) for name, poses in paper_trajectories().items()})


def plan_of(commands: dict[str, Array]) -> Plan:
    """Return the plan that runs through the named (N_i, n) command blocks in their order."""
    names = np.concatenate([np.full(len(q), name) for name, q in commands.items()])
    q_cmd = np.concatenate(list(commands.values()))
    return Plan(names, q_cmd, np.zeros(len(q_cmd)))


def steps_between(q_from: Array, q_to: Array, max_step_rad: float) -> Array:
    """(k, n) poses on the straight line from `q_from` to `q_to`, the end included, none further than the step apart."""
    k = max(1, int(np.ceil(np.abs(q_to - q_from).max() / max_step_rad - ROUNDING_RAD)))
    share = np.arange(1, k + 1)[:, None] / k
    poses: Array = q_from + share * (q_to - q_from)
    poses[-1] = q_to
    return poses


def read_plan(path: Path, n_joints: int) -> Plan:
    """Read a plan file: `trajectory, theta1_cmd_rad, ...` and maybe `payload_kg`; raises `InputError`."""
    joints = [f"theta{i + 1}_cmd_rad" for i in range(n_joints)]
    required, valid = ["trajectory", *joints], ["trajectory", *joints, "payload_kg"]
    try:
        if path.stat().st_size > _MAX_BYTES:
            raise InputError(f"{path.name}: larger than {_MAX_BYTES} bytes, no plan")
        with path.open(encoding="utf-8-sig", newline="") as stream:
            lines = list(csv.reader(stream))
    except (FileNotFoundError, IsADirectoryError):
        raise InputError(f"{path}: no such file; a plan is a CSV with columns {', '.join(required)}") from None
    except (UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"{path.name}: not a CSV file in UTF-8 ({error})") from None
    while lines and not lines[-1]:  # blank lines at the end; one between rows would shift every line number
        lines.pop()
    columns = [name.strip() for name in lines[0]] if lines else []
    for name in columns:
        if name not in valid:
            raise InputError(f"{path.name}: unknown column '{shown(name)}'{nearest(name, valid)}")
    for name in required:
        if columns.count(name) != 1:
            raise InputError(f"{path.name}: column '{name}' is wanted once, found {columns.count(name)} times")
    if len(lines) < 2:
        raise InputError(f"{path.name}: no poses; one row a pose is wanted")
    for number, line in enumerate(lines[1:], start=2):
        if len(line) != len(columns):
            raise InputError(f"{path.name}: line {number} has {len(line)} cells, the header has {len(columns)}")
    numbers = {
        name: np.array([_number(path, number, name, line[columns.index(name)]) for number, line in _numbered(lines)])
        for name in columns
        if name != "trajectory"
    }
    q_cmd = np.stack([numbers[name] for name in joints], axis=-1)
    too_large = np.argwhere(np.abs(q_cmd) > 2 * np.pi)
    if len(too_large):
        row, joint = too_large[0]
        raise InputError(
            f"{path.name}: line {row + 2}, column '{joints[joint]}': {q_cmd[row, joint]:g} is beyond 2 pi; "
            "angles are in radians, these look like degrees: multiply by pi/180"
        )
    for row, payload in enumerate(numbers.get("payload_kg", np.zeros(0))):
        if not 0 <= payload <= _MOST_PAYLOAD_KG:
            raise InputError(
                f"{path.name}: line {row + 2}, column 'payload_kg': {payload:g} found, 0 to {_MOST_PAYLOAD_KG:g} is "
                "wanted, in kilograms"
            )
    names = np.array([line[columns.index("trajectory")] for line in lines[1:]], dtype=np.str_)
    return Plan(names, q_cmd, numbers.get("payload_kg", np.zeros(len(q_cmd))))


def write_plan(path: Path, plan: Plan) -> None:
    """Write a plan file atomically."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(["trajectory", *(f"theta{i + 1}_cmd_rad" for i in range(plan.q_cmd.shape[1])), "payload_kg"])
    for name, q, payload in zip(plan.trajectory, plan.q_cmd, plan.payload_kg, strict=True):
        writer.writerow([str(name), *(repr(float(angle)) for angle in q), repr(float(payload))])
    atomic.write_text(path, out.getvalue())


def _numbered(lines: list[list[str]]) -> list[tuple[int, list[str]]]:
    return list(enumerate(lines[1:], start=2))


def _number(path: Path, line: int, column: str, text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InputError(f"{path.name}: line {line}, column '{column}': '{text[:40]}' is no finite number")
    return value
