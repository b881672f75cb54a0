"""Twin files of moving arms (`armtwin.twin/1` with `motion = "moving"`): its arm, its zeros and what was found.

schema = "armtwin.twin/1"
motion = "moving"
[arm]                                         # as in a recording: link lengths, or a model file beside the twin
[geometry]
joint_errors_rad = [0.01, -0.02, 0.0]         # what each joint reads where the model's angle is zero
[[effects]]
effect = "friction"
joint = 2
parameters = { coulomb_rad = 0.0123 }         # as the effect's injector takes them
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from armtwin.models.arm import arm_from_table
from armtwin.models.catalogue.motion_injection import MotionCause, with_causes
from armtwin.models.catalogue.site import Site
from armtwin.models.errors import InputError
from armtwin.models.motion_arm import MotionArm, model_arm, planar_arm
from armtwin.models.motion_world import ideal_motion_world
from armtwin.models.toml_reader import read_toml
from armtwin.models.validation import FROM_LIST, ArmTable, Finite, Strict, check

Array = NDArray[np.float64]

_MOST_JOINTS = 7
_Name = Annotated[str, Field(min_length=1, max_length=200)]


class _ModelTable(Strict):
    name: _Name
    model: _Name
    joints: Annotated[tuple[_Name, ...], Field(min_length=1, max_length=_MOST_JOINTS), FROM_LIST]


class _GeometryTable(Strict):
    length_errors_mm: Annotated[tuple[Finite, ...], Field(max_length=_MOST_JOINTS + 1), FROM_LIST] = ()
    joint_errors_rad: Annotated[tuple[Finite, ...], Field(max_length=_MOST_JOINTS), FROM_LIST] = ()


class _EffectTable(Strict):
    effect: _Name
    joint: int | None = None
    parameters: dict[str, Any] = Field(default_factory=dict)  # checked by the effect


class _TwinFile(Strict):
    schema_: Literal["armtwin.twin/1"] = Field(alias="schema")
    motion: Literal["moving"]
    arm: _ModelTable | ArmTable
    geometry: _GeometryTable = _GeometryTable()
    effects: Annotated[tuple[_EffectTable, ...], Field(max_length=100), FROM_LIST] = ()


@dataclass(frozen=True, eq=False)
class MovingTwin:
    """An arm, what its joints read at zero (n,), rad, and what is made of it physically."""

    arm: MotionArm
    zeros_rad: Array
    causes: tuple[MotionCause, ...]


def is_moving_twin(path: Path) -> bool:
    """Whether a file says that it is a moving arm's twin; raises `InputError` for one that is no TOML."""
    return path.is_file() and read_toml(path).get("motion") == "moving"


def read_moving_twin(path: Path, model: Path | None = None) -> MovingTwin:
    """Read a moving arm's twin; raises `InputError` with the file and the key.

    `model` is the file of an arm that is given by a model, by default the one of its name beside the twin.
    """
    table = check(_TwinFile, read_toml(path), path.name)
    arm = _arm(table.arm, path, model)
    zeros = np.array(table.geometry.joint_errors_rad or (0.0,) * arm.n_joints)
    if len(zeros) != arm.n_joints:
        raise InputError(
            f"{path.name}: geometry.joint_errors_rad: {len(zeros)} found, {arm.n_joints} are wanted, one a joint"
        )
    causes = tuple((one.effect, Site(joint=one.joint), one.parameters) for one in table.effects)
    try:
        with_causes(ideal_motion_world(arm, zeros), causes)
    except InputError as error:
        raise InputError(f"{path.name}: effects: {error}") from None
    return MovingTwin(arm, zeros, causes)


def _arm(table: _ModelTable | ArmTable, path: Path, model: Path | None) -> MotionArm:
    if isinstance(table, ArmTable):
        return planar_arm(arm_from_table(table))
    beside = path.parent / table.model
    if model is None and (Path(table.model).is_absolute() or path.parent.resolve() not in beside.resolve().parents):
        raise InputError(f"{path.name}: arm.model: '{table.model[:80]}' leaves the twin's folder")
    file = beside if model is None else model
    if not file.is_file():
        raise InputError(f"{file}: no such file; copy {table.model} beside the twin, or give --model FILE")
    return model_arm(table.name, file, table.joints)
