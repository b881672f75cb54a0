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
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
import tomli_w
from numpy.typing import NDArray
from pydantic import Field

from armtwin.models.arm import Arm, arm_from_table
from armtwin.models.catalogue.motion_injection import MotionCause, with_causes
from armtwin.models.catalogue.site import Site
from armtwin.models.errors import InputError
from armtwin.models.motion_arm import MotionArm, model_arm, planar_arm
from armtwin.models.motion_world import ideal_motion_world
from armtwin.models.recordings.moving import ModelArm
from armtwin.models.recordings.moving_writer import declared_arm
from armtwin.models.tabular import html_table
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
    """A measured arm in motion.

    Attributes:
        declared: its arm as files state it: link lengths, or a model.
        zeros_rad: (n,) what its joints read at zero.
        causes: what is made of it physically.

    """

    declared: Arm | ModelArm
    zeros_rad: Array
    causes: tuple[MotionCause, ...]

    @cached_property
    def arm(self) -> MotionArm:
        """The arm that moves; raises `InputError` where its model does not load."""
        if isinstance(self.declared, Arm):
            return planar_arm(self.declared)
        return model_arm(self.declared.name, self.declared.model, self.declared.joints)

    def columns(self) -> dict[str, Any]:
        """Return a row a parameter of each cause: effect, joint, parameter, value."""
        rows = [(name, site.joint, key, value) for name, site, values in self.causes for key, value in values.items()]
        return {key: [row[k] for row in rows] for k, key in enumerate(("effect", "joint", "parameter", "value"))}

    def _repr_html_(self) -> str:
        return html_table(f"Moving twin of '{self.declared.name}': {len(self.causes)} causes", self.columns())


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
    twin = MovingTwin(arm, zeros, causes)
    try:
        with_causes(ideal_motion_world(twin.arm, zeros), causes)
    except InputError as error:
        raise InputError(f"{path.name}: effects: {error}") from None
    return twin


def moving_twin_text(twin: MovingTwin, comment: str = "") -> str:
    """Return the content of a moving twin's file, headed by the lines of `comment`."""
    zeros: dict[str, Any] = {"joint_errors_rad": [float(zero) for zero in twin.zeros_rad]}
    if isinstance(twin.declared, Arm):
        zeros = {"length_errors_mm": [0.0] * len(twin.declared.link_lengths_mm), **zeros}
    table: dict[str, Any] = {
        "schema": "armtwin.twin/1",
        "motion": "moving",
        "arm": declared_arm(twin.declared),
        "geometry": zeros,
    }
    if twin.causes:
        table["effects"] = [
            {"effect": name, **({} if site.joint is None else {"joint": site.joint}), "parameters": dict(values)}
            for name, site, values in twin.causes
        ]
    return "".join(f"# {line}\n" for line in comment.splitlines()) + tomli_w.dumps(table)


def _arm(table: _ModelTable | ArmTable, path: Path, model: Path | None) -> Arm | ModelArm:
    if isinstance(table, ArmTable):
        return arm_from_table(table)
    beside = path.parent / table.model
    if model is None and (Path(table.model).is_absolute() or path.parent.resolve() not in beside.resolve().parents):
        raise InputError(f"{path.name}: arm.model: '{table.model[:80]}' leaves the twin's folder")
    file = beside if model is None else model
    if not file.is_file():
        raise InputError(f"{file}: no such file; copy {table.model} beside the twin, or give --model FILE")
    return ModelArm(table.name, table.joints, file)
