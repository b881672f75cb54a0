"""Plans by name or file: the paper's, commands of a diagnosis, or poses of the tip for any arm that can reach them."""

from __future__ import annotations

import contextlib
import csv
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from armtwin.models.arm import Arm
from armtwin.models.errors import InputError, UnreachablePoseError
from armtwin.models.kinematics import inverse
from armtwin.models.plan import Plan, paper_plan, read_plan

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
    with path.open("rb") as stream:
        head = stream.readline(10_000).decode("utf-8", "replace")
    return any(column in head for column in _POSE_COLUMNS)


def _poses_plan(path: Path, arm: Arm) -> Plan:
    if path.stat().st_size > _MAX_BYTES:
        raise InputError(f"{path.name}: larger than {_MAX_BYTES} bytes, no plan")
    try:
        with path.open(encoding="utf-8-sig", newline="") as stream:
            lines = [line for line in csv.reader(stream) if line]
    except (UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"{path.name}: not a CSV file in UTF-8 ({error})") from None
    columns = [name.strip() for name in lines[0]]
    wanted = ["trajectory", *_POSE_COLUMNS]
    if sorted(columns) != sorted(wanted):
        raise InputError(f"{path.name}: columns {', '.join(columns)[:100]} found, {', '.join(wanted)} wanted")
    if len(lines) < 2:
        raise InputError(f"{path.name}: no poses; one row a pose is wanted")
    poses = np.array([_pose(path, number, columns, line) for number, line in enumerate(lines[1:], start=2)])
    names = np.array([line[columns.index("trajectory")] for line in lines[1:]], dtype=np.str_)
    try:
        q_cmd = inverse(arm, poses)
    except UnreachablePoseError as error:
        raise UnreachablePoseError(f"{path.name}: {error} (pose 0 stands in line 2)") from None
    return Plan(names, q_cmd, np.zeros(len(q_cmd)))


def _pose(path: Path, number: int, columns: list[str], line: list[str]) -> NDArray[np.float64]:
    if len(line) != len(columns):
        raise InputError(f"{path.name}: line {number} has {len(line)} cells, the header has {len(columns)}")
    values = np.full(3, np.nan)
    for k, column in enumerate(_POSE_COLUMNS):
        text = line[columns.index(column)]
        with contextlib.suppress(ValueError):  # stays NaN
            values[k] = float(text)
        if not abs(values[k]) < _FAR:
            raise InputError(
                f"{path.name}: line {number}, column '{column}': '{text[:40]}' is no finite number below {_FAR:g}"
            )
    if abs(values[2]) > 2 * np.pi:
        raise InputError(
            f"{path.name}: line {number}, column 'theta_rad': {values[2]:g} is beyond 2 pi; angles are in radians, "
            "this looks like degrees: multiply by pi/180"
        )
    return values
