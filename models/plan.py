"""Plans: the poses of a recording to be made, a CSV that the simulated, the emulated and the real bench execute."""

from __future__ import annotations

import csv
import io
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from armtwin.models import atomic
from armtwin.models.arm import Arm
from armtwin.models.csv_table import CsvTable, finite, in_units, read_csv
from armtwin.models.errors import InputError
from armtwin.models.inverse_kinematics import inverse
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
    """(N,) trajectory names, (N, n) commands in rad, (N,) payload to hang at the tip in kg (0 where none).

    `time_s` (N,) is when each command is given to an arm that is filmed on its way, where the plan says so.
    """

    trajectory: NDArray[np.str_]
    q_cmd: Array
    payload_kg: Array
    time_s: Array | None = None

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
    """Read a plan file: `theta1_cmd_rad, ...`, and maybe `trajectory` and `payload_kg`; raises `InputError`.

    A plan without `trajectory` is one trajectory, named after its file.
    """
    joints = [f"theta{i + 1}_cmd_rad" for i in range(n_joints)]
    what = f"a CSV with columns trajectory, {', '.join(joints)}"
    _refuse_more_joints(path, n_joints)
    table = read_plan_table(path, ["trajectory", "time_s", *joints, "payload_kg"], what)
    for name in joints:
        if name not in table.columns:
            raise InputError(f"{path.name}: column '{name}' is missing; a plan has one for each joint")
    rows = range(len(table))
    q_cmd = np.array([[finite(table, row, name) for name in joints] for row in rows])
    too_large = np.argwhere(np.abs(q_cmd) > 2 * np.pi)
    if len(too_large):
        row, joint = too_large[0]
        raise InputError(
            f"{table.at(row, joints[joint])}: {q_cmd[row, joint]:g} is beyond 2 pi; angles are in radians, these look "
            f"like degrees: name the column {joints[joint].removesuffix('_rad')}_deg, or multiply by pi/180"
        )
    payload_kg = np.zeros(len(table))
    if "payload_kg" in table.columns:
        payload_kg = np.array([finite(table, row, "payload_kg") for row in rows])
        beyond = np.flatnonzero((payload_kg < 0) | (payload_kg > _MOST_PAYLOAD_KG))
        if len(beyond):
            row = int(beyond[0])
            raise InputError(
                f"{table.at(row, 'payload_kg')}: {payload_kg[row]:g} found, 0 to {_MOST_PAYLOAD_KG:g} is wanted, in "
                "kilograms"
            )
    return Plan(trajectories_of(table, path), q_cmd, payload_kg, _times_of(table))


def _refuse_more_joints(path: Path, n_joints: int) -> None:
    """Raise `InputError` where a plan is of an arm with more joints."""
    if not path.is_file():
        return
    columns = read_csv(path, _MAX_BYTES, "one row a pose").columns
    numbers = [int(found[1]) for name in columns if (found := re.fullmatch(r"theta(\d{1,3})_cmd_(?:rad|deg)", name))]
    if numbers and max(numbers) > n_joints:
        raise InputError(
            f"{path.name}: commands joint {max(numbers)}, and this arm has {n_joints}; is it another arm's?"
        )


def _times_of(table: CsvTable) -> Array | None:
    if "time_s" not in table.columns:
        return None
    time_s = np.array([finite(table, row, "time_s") for row in range(len(table))])
    back = np.flatnonzero(np.diff(time_s) <= 0)
    if len(back):
        row = int(back[0]) + 1
        raise InputError(f"{table.at(row, 'time_s')}: {time_s[row]:g} s is not after {time_s[row - 1]:g} s; times grow")
    return time_s


def read_plan_table(path: Path, valid: list[str], what: str) -> CsvTable:
    """Read the cells of a plan whose columns are among `valid`; raises `InputError` that says `what` a plan is."""
    if not path.is_file():
        raise InputError(f"{path}: no such file; a plan is {what}")
    return in_units(read_csv(path, _MAX_BYTES, "one row a pose"), valid)


def trajectories_of(table: CsvTable, path: Path) -> NDArray[np.str_]:
    """(N,) names of the trajectories of a plan; the file's where it has no such column."""
    if "trajectory" not in table.columns:
        return np.full(len(table), path.stem or "plan")
    return np.array([table.text(row, "trajectory") for row in range(len(table))], dtype=np.str_)


def write_plan(path: Path, plan: Plan) -> None:
    """Write a plan file atomically; with `time_s` where the plan has times of its own."""
    times = [] if plan.time_s is None else [("time_s", plan.time_s)]
    columns = [
        *times,
        *((f"theta{i + 1}_cmd_rad", q) for i, q in enumerate(plan.q_cmd.T)),
        ("payload_kg", plan.payload_kg),
    ]
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(["trajectory", *(name for name, _ in columns)])
    for row, name in enumerate(plan.trajectory):
        writer.writerow([str(name), *(repr(float(values[row])) for _, values in columns)])
    atomic.write_text(path, out.getvalue())
