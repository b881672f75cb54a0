"""Twin files (`armtwin.twin/1`): an arm with its calibrated geometry, its camera and the effects that were found.

A twin is all that the simulated bench needs to behave as a measured one: `rebuild` returns its world, in which every
effect is made physically by its injector. The file is TOML:

    schema = "armtwin.twin/1"
    [arm]                                         # as in a recording: the drawing
    [geometry]                                    # what the built arm differs by
    length_errors_mm = [0.6, -1.3, 0.2, 0.0]
    joint_errors_rad = [0.01, -0.02, 0.0]
    base_in_board_mm = [31.5, -28.1, -80.87]      # marker A; its z is the arm's plane
    [camera]                                      # as in a recording; left out where only angles were measured
    [[effects]]
    effect = "backlash"
    joint = 2
    parameters = { width_rad = 0.0098 }           # as the effect's injector takes them
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
import tomli_w
from numpy.typing import NDArray
from pydantic import Field, model_validator

from armtwin.models import atomic
from armtwin.models.arm import Arm, arm_from_table
from armtwin.models.arm_form import form_named
from armtwin.models.camera import Camera
from armtwin.models.camera_files import nominal_camera
from armtwin.models.catalogue.injection import Stated
from armtwin.models.catalogue.registry import effect_named
from armtwin.models.catalogue.site import Site
from armtwin.models.errors import InputError
from armtwin.models.kinematics import Deviation
from armtwin.models.recordings.reader import camera_from_table
from armtwin.models.recordings.writer import arm_table, camera_table
from armtwin.models.toml_reader import read_toml
from armtwin.models.validation import (
    FROM_LIST,
    ArmTable,
    CameraTable,
    Finite,
    JointError,
    LengthError,
    Strict,
    check,
    row,
)
from armtwin.models.world import World, ideal_world

Array = NDArray[np.float64]

SCHEMA = "armtwin.twin/1"


@dataclass(frozen=True, eq=False)
class TwinEffect:
    """An effect of a twin: its name, joint (from 1) or marker, and its injector's parameters."""

    effect: str
    joint: int | None
    marker: str | None
    parameters: Mapping[str, Any]

    @property
    def site(self) -> Site:
        """Where it sits."""
        return Site(self.joint, self.marker)


@dataclass(frozen=True, eq=False)
class Twin:
    """A measured bench.

    Attributes:
        arm: the drawing.
        deviation: true lengths and joint zeros less the drawn ones, in the convention of the fit's gauge.
        base_in_board_mm: (3,) marker A's axis; its z is the arm's plane.
        camera: as calibrated; None where only joint angles were measured.
        effects: what was found.

    """

    arm: Arm
    deviation: Deviation
    base_in_board_mm: Array
    camera: Camera | None
    effects: tuple[TwinEffect, ...]


class _GeometryTable(Strict):
    length_errors_mm: Annotated[list[LengthError], Field(max_length=7)]
    joint_errors_rad: Annotated[list[JointError], Field(max_length=6)]
    base_in_board_mm: Annotated[tuple[Finite, Finite, Finite], FROM_LIST] = (0.0, 0.0, 0.0)


class _EffectTable(Strict):
    effect: str
    joint: int | None = None
    marker: Annotated[str, Field(max_length=100)] | None = None
    parameters: dict[str, Any] = Field(default_factory=dict)  # checked by the effect


class _TwinFile(Strict):
    schema_: Literal["armtwin.twin/1"] = Field(alias="schema")
    arm: ArmTable
    geometry: _GeometryTable
    camera: CameraTable | None = None
    effects: list[_EffectTable] = Field(default_factory=list, max_length=100)

    @model_validator(mode="after")
    def _geometry_is_of_the_arm(self) -> _TwinFile:
        lengths = len(self.arm.link_lengths_mm)
        joints = form_named(self.arm.name).joints_of(lengths)
        for key, wanted in (("length_errors_mm", lengths), ("joint_errors_rad", joints)):
            found = len(getattr(self.geometry, key))
            if found != wanted:
                raise ValueError(f"geometry.{key} needs {wanted} entries for arm '{self.arm.name}', found {found}")
        return self


def read_twin(path: Path) -> Twin:
    """Read a twin file; raises `InputError` for what is no twin, and for an effect that no registry has or can make."""
    file = check(_TwinFile, read_toml(path), path.name)
    arm = arm_from_table(file.arm)
    for number, effect in enumerate(file.effects):
        try:
            known = effect_named(effect.effect)
        except InputError as error:
            raise InputError(f"{path.name}: {row('effects', number)}: effect: {error}") from None
        try:
            at = f"{row('effects', number)}: "
            known.check(Stated(effect.parameters, Site(effect.joint, effect.marker), at, "parameters."), arm)
        except InputError as error:
            raise InputError(f"{path.name}: {error}") from None
    geometry = file.geometry
    return Twin(
        arm=arm,
        deviation=Deviation(np.array(geometry.length_errors_mm), np.array(geometry.joint_errors_rad)),
        base_in_board_mm=np.array(geometry.base_in_board_mm),
        camera=None if file.camera is None else camera_from_table(file.camera),
        effects=tuple(TwinEffect(e.effect, e.joint, e.marker, dict(e.parameters)) for e in file.effects),
    )


def twin_text(twin: Twin, comment: str = "") -> str:
    """Return the content of a twin file, headed by the lines of `comment`."""
    table: dict[str, Any] = {
        "schema": SCHEMA,
        "arm": arm_table(twin.arm),
        "geometry": {
            "length_errors_mm": twin.deviation.lengths_mm.tolist(),
            "joint_errors_rad": twin.deviation.joints_rad.tolist(),
            "base_in_board_mm": twin.base_in_board_mm.tolist(),
        },
    }
    if twin.camera is not None:
        table["camera"] = camera_table(twin.camera)
    if twin.effects:
        table["effects"] = [_effect_table(effect) for effect in twin.effects]
    head = "".join(f"# {line}\n" for line in comment.splitlines())
    return head + tomli_w.dumps(table)


def write_twin(path: Path, twin: Twin, comment: str = "") -> None:
    """Write a twin file atomically."""
    atomic.write_text(path, twin_text(twin, comment))


def rebuild(twin: Twin) -> World:
    """Return the world of a twin: its geometry, and each effect made by its injector in the order of the stages.

    A twin without a camera gets the nominal one, which nobody looks through. Raises `InputError` where an injector is
    given what it does not take, or where no arm can be built with it.
    """
    camera = nominal_camera() if twin.camera is None else twin.camera
    plane_z_mm = float(twin.base_in_board_mm[2])
    world = ideal_world(twin.arm, camera, plane_z_mm, twin.base_in_board_mm, twin.deviation)
    for effect in sorted(twin.effects, key=lambda effect: effect_named(effect.effect).stage):
        try:
            world = effect_named(effect.effect).inject(world, effect.parameters, effect.site)
            world.compile()
        except InputError as error:
            raise InputError(f"effect '{effect.effect}': {error}") from None
    return world


def _effect_table(effect: TwinEffect) -> dict[str, Any]:
    table: dict[str, Any] = {"effect": effect.effect}
    return {**table, **effect.site.keys, "parameters": dict(effect.parameters)}
