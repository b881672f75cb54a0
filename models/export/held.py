"""Which effects of a twin a model file can hold: told by what each effect's injector changes of the bench."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from armtwin.models.catalogue.registry import effect_named
from armtwin.models.twin import Twin, TwinEffect, rebuild
from armtwin.models.world import World

SCHEMA = "armtwin.export/1"
# What a change of the bench means for a file that describes an arm and nothing else.
_BEYOND_THE_ARM = {
    "electronics": "acts on the commands on their way to the servos",
    "camera_motion": "belongs to the camera",
    "true_camera": "belongs to the camera",
    "detections": "belongs to the detection of markers",
    "picture_lag": "belongs to how pictures are filed",
    "base_in_board_mm": "belongs to where the arm stands before the camera",
}


@dataclass(frozen=True)
class NotHeld:
    """An effect that a file does not hold, and why."""

    effect: TwinEffect
    why: str


@dataclass(frozen=True)
class Held:
    """The effects of a twin by whether a model of the arm alone can hold them, in the twin's order."""

    held: tuple[TwinEffect, ...]
    not_held: tuple[NotHeld, ...]


def effects_held(twin: Twin, gears: bool = False) -> Held:
    """Tell which effects lie in the arm's mechanics, or (with `gears`) can be made by the gear of an actuator."""
    bare = rebuild(Twin(twin.arm, twin.deviation, twin.base_in_board_mm, twin.camera, ()))
    held, not_held = [], []
    for effect in twin.effects:
        known = effect_named(effect.effect)
        alone = known.inject(bare, effect.parameters, effect.site)
        why = [reason for name, reason in _BEYOND_THE_ARM.items() if _differs(bare, alone, name)]
        if why and not (gears and known.as_gear):
            not_held.append(NotHeld(effect, why[0]))
        else:
            held.append(effect)
    return Held(tuple(held), tuple(not_held))


def held_by_rigid_links(twin: Twin) -> Held:
    """Tell which effects a file of rigid links, joints and masses holds: no second hinge at a joint, no other servo."""
    bare = rebuild(Twin(twin.arm, twin.deviation, twin.base_in_board_mm, twin.camera, ()))
    joints = bare.arm.n_joints
    found = effects_held(twin)
    held, not_held = [], list(found.not_held)
    for effect in found.held:
        alone = effect_named(effect.effect).inject(bare, effect.parameters, effect.site)
        spec = alone.spec()
        if len(spec.joints) > joints or len(spec.tendons):
            not_held.append(NotHeld(effect, "needs a spring, a gap or a friction element behind the servo"))
        elif alone.servo != bare.servo:
            not_held.append(NotHeld(effect, "belongs to the servo's loop"))
        else:
            held.append(effect)
    return Held(tuple(held), tuple(not_held))


def effect_table(effect: TwinEffect) -> dict[str, Any]:
    """Return an effect as JSON takes it."""
    return {
        "effect": effect.effect,
        "joint": effect.joint,
        "marker": effect.marker,
        "parameters": dict(effect.parameters),
    }


def label(effect: TwinEffect) -> str:
    """Return an effect's name and site for people."""
    if effect.joint is not None:
        return f"{effect.effect} (joint {effect.joint})"
    return f"{effect.effect} (marker {effect.marker})" if effect.marker else effect.effect


def _differs(one: World, other: World, name: str) -> bool:
    assert name in {field.name for field in fields(World)}
    first, second = getattr(one, name), getattr(other, name)
    if isinstance(first, np.ndarray):
        return not np.array_equal(first, second)
    return first is not second and bool(first != second)
