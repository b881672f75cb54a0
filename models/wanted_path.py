"""What a person wants of the arm: a plan's joint poses, or points of the tip, for `armtwin correct`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from armtwin.models.arm import Arm
from armtwin.models.csv_table import finite
from armtwin.models.errors import InputError
from armtwin.models.plan import read_plan, read_plan_table, trajectories_of
from armtwin.models.trajectories import paper_trajectories

Array = NDArray[np.float64]

_POINTS = ("x_mm", "y_mm")
_ORIENTATION = "theta_F_rad"
# Ten metres: nothing that an arm on a table reaches.
_FAR_MM = 1e4


@dataclass(frozen=True, eq=False)
class WantedPath:
    """Either (N, n) joint poses `q`, rad, or (N, 2) tip points `tip_mm` with maybe (N,) orientations `theta_rad`.

    `trajectory` (N,) names, `payload_kg` (N,) what hangs at the tip, `places` (N,) where each row stands in its file.
    """

    trajectory: NDArray[np.str_]
    payload_kg: Array
    places: tuple[str, ...]
    q: Array | None = None
    tip_mm: Array | None = None
    theta_rad: Array | None = None

    def __len__(self) -> int:
        return len(self.trajectory)


def wanted_path(name: str, arm: Arm) -> WantedPath:
    """Return the path of a file, or of the paper's trajectories where `name` is 'paper'; raises `InputError`."""
    if name != "paper":
        return read_wanted_path(Path(name), arm)
    paths = paper_trajectories()
    poses = np.concatenate(list(paths.values()))
    names = np.concatenate([np.full(len(path), trajectory) for trajectory, path in paths.items()])
    places = tuple(f"pose {row}" for row in range(len(poses)))
    return WantedPath(names, np.zeros(len(poses)), places, tip_mm=poses[:, :2], theta_rad=poses[:, 2])


def read_wanted_path(path: Path, arm: Arm) -> WantedPath:
    """Read `theta1_cmd_rad, …` or `x_mm, y_mm[, theta_F_rad]`, maybe with `trajectory` and `payload_kg`.

    Raises `InputError` for a file that holds both or neither, and as `read_plan` does.
    """
    joints = [f"theta{i + 1}_cmd_rad" for i in range(arm.n_joints)]
    points = [*_POINTS, _ORIENTATION]
    what = f"a CSV with {', '.join(joints)} (joint poses) or x_mm, y_mm[, {_ORIENTATION}] (the tip)"
    table = read_plan_table(path, ["trajectory", *joints, *points, "payload_kg"], what)
    has_points = [name for name in points if name in table.columns]
    has_joints = [name for name in joints if name in table.columns]
    if has_points and has_joints:
        raise InputError(f"{path.name}: has '{has_joints[0]}' and '{has_points[0]}'; one of both says where to go")
    places = tuple(f"line {line}" for line in table.lines)
    if has_joints:
        plan = read_plan(path, arm.n_joints)
        return WantedPath(plan.trajectory, plan.payload_kg, places, q=plan.q_cmd)
    for name in _POINTS:
        if name not in table.columns:
            raise InputError(f"{path.name}: column '{name}' is missing; wanted is {what}")
    rows = range(len(table))
    tip = np.array([[finite(table, row, name) for name in _POINTS] for row in rows])
    far = np.argwhere(np.abs(tip) > _FAR_MM)
    if len(far):
        row, column = far[0]
        raise InputError(f"{table.at(row, _POINTS[column])}: {tip[row, column]:g} is beyond {_FAR_MM:g} mm")
    theta = None
    if _ORIENTATION in table.columns:
        theta = np.array([finite(table, row, _ORIENTATION) for row in rows])
        turned = np.flatnonzero(np.abs(theta) > 2 * np.pi)
        if len(turned):
            row = int(turned[0])
            raise InputError(
                f"{table.at(row, _ORIENTATION)}: {theta[row]:g} is beyond 2 pi; name the column theta_F_deg for degrees"
            )
    payload = np.zeros(len(table))
    if "payload_kg" in table.columns:
        payload = np.array([finite(table, row, "payload_kg") for row in rows])
        if (payload < 0).any() or (payload > 5).any():
            row = int(np.argmax((payload < 0) | (payload > 5)))
            raise InputError(f"{table.at(row, 'payload_kg')}: {payload[row]:g} found, 0 to 5 is wanted, in kilograms")
    return WantedPath(trajectories_of(table, path), payload, places, tip_mm=tip, theta_rad=theta)
