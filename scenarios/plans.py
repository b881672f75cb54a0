"""Plans by name or file: the paper's, commands of a diagnosis, or poses of the tip for any arm that can reach them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from armtwin.models.arm import Arm
from armtwin.models.csv_table import CsvTable, finite, read_csv
from armtwin.models.errors import InputError, UnreachablePoseError
from armtwin.models.inverse_kinematics import inverse
from armtwin.models.plan import Plan, paper_plan, read_plan, read_plan_table, trajectories_of

BUILT_IN = ("paper",)
_POSE_COLUMNS = ("x_mm", "y_mm", "theta_rad")
_MAX_BYTES = 1 << 26
# A kilometre in mm: nothing that an arm reaches, and its square is still a number.
_FAR = 1e6


def load_plan(name: str, arm: Arm) -> Plan:
    """Return the plan `paper`, or that of a CSV file.

    The file has `trajectory` and either the commands `theta1_cmd_rad, ...` (and maybe `payload_kg`) or the tip's poses
    `x_mm, y_mm, theta_rad`, which go through the nominal inverse kinematics. Raises `InputError`.
    """
    if name in BUILT_IN:
        return paper_plan(arm)
    path = Path(name)
    if not path.is_file():
        raise InputError(f"--plan: no file '{name}'; give a CSV, or one of {', '.join(BUILT_IN)}")
    return _poses_plan(path, arm) if _has_poses(path) else read_plan(path, arm.n_joints)


def _has_poses(path: Path) -> bool:
    columns = read_csv(path, _MAX_BYTES, "one row a pose").columns
    return any(column in columns for column in ("x_mm", "y_mm"))


def _poses_plan(path: Path, arm: Arm) -> Plan:
    table = read_plan_table(path, ["trajectory", *_POSE_COLUMNS], "a CSV of poses or of commands")
    for column in _POSE_COLUMNS:
        if column not in table.columns:
            wanted = ", ".join(_POSE_COLUMNS)
            raise InputError(f"{path.name}: column '{column}' is missing; a pose of the tip is {wanted}")
    poses = np.array([_pose(table, row) for row in range(len(table))])
    try:
        q_cmd = inverse(arm, poses)
    except UnreachablePoseError as error:
        raise UnreachablePoseError(f"{path.name}: {error} (pose 0 stands in line {table.lines[0]})") from None
    return Plan(trajectories_of(table, path), q_cmd, np.zeros(len(q_cmd)))


def _pose(table: CsvTable, row: int) -> NDArray[np.float64]:
    values = np.array([finite(table, row, column) for column in _POSE_COLUMNS])
    for column, value in zip(_POSE_COLUMNS, values, strict=True):
        if abs(value) >= _FAR:
            raise InputError(f"{table.at(row, column)}: '{value:g}' is no finite number below {_FAR:g}")
    if abs(values[2]) > 2 * np.pi:
        raise InputError(
            f"{table.at(row, 'theta_rad')}: {values[2]:g} is beyond 2 pi; angles are in radians, this looks like "
            "degrees: name the column theta_deg, or multiply by pi/180"
        )
    return values
