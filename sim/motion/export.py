"""A moving twin as an MJCF file that plain MuJoCo steps as the twin moves, and beside it what such a file cannot hold.

Actuator `drive_NAME` takes the command of joint NAME, rad, from the moment at which it is given; the file's time step
is the one for which its armatures and dampings are made, and must stay. A heavy rotor is brought up to speed by no more
than the torque that keeps the top speed, which shows in steps of more than 0.1 rad alone.

What reaches the drives on wires (a delay, a count, a dead band), what the loops give under loads and what happens at a
moment stand in the note beside the file, each with the lines that make it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from armtwin.models import atomic
from armtwin.models.catalogue.motion_injection import MotionCause, inject_in_motion
from armtwin.models.export.held import SCHEMA
from armtwin.models.export.mjcf import note_beside
from armtwin.models.mjcf import building
from armtwin.models.motion_arm import MotionArm
from armtwin.models.motion_world import Drive, MotionWorld, ideal_motion_world
from armtwin.sim.motion.drive import STIFFNESS_NM_RAD, DriveBank
from armtwin.sim.motion.model import LONGEST_STEP_S, drive_name, motion_spec

Array = NDArray[np.float64]

# Numbers of a drive that follow the load or the speed at every step, which no file holds.
_AT_EVERY_STEP = {
    "torque_nm": "model.actuator_forcerange[i] scales, up by 1 - hold / torque_nm and down by 1 + hold / torque_nm, "
    "each within 0 to 1, with hold = data.qfrc_gravcomp[dof]",
    "compliance_rad_per_nm": "data.ctrl[i] = command - compliance_rad_per_nm * data.qfrc_gravcomp[dof]",
    "payload_compliance_rad_per_nm": "data.ctrl[i] = command - compliance_rad_per_nm * (torque that holds the mass)",
    "stribeck_rad": "model.dof_frictionloss[dof] += stiffness * stribeck_rad * "
    "exp(-(data.qvel[dof] / stribeck_speed_rad_s) ** 2)",
    "load_share": "model.dof_frictionloss[dof] += stiffness * load_share * compliance * abs(data.qfrc_gravcomp[dof]), "
    "the compliance being the nominal loop's, 1 / 50 rad/(N m), where the joint has none of its own",
    "drive_share": "model.dof_frictionloss[dof] += drive_share * abs(data.actuator_force[i] - "
    "model.dof_damping[dof] * data.qvel[dof])",
    "stribeck_load_share": "as load_share, times exp(-(data.qvel[dof] / stribeck_speed_rad_s) ** 2)",
    "stribeck_drive_share": "as drive_share, times exp(-(data.qvel[dof] / stribeck_speed_rad_s) ** 2)",
}
_ON_THE_WIRE = {
    "latency": "data.ctrl[i] = the command that was in force delay_s ago",
    "sampling": "from from_s on data.ctrl[:] = the commands that were in force delay_s ago; of held_rows one is sent",
    "dead_band": "data.ctrl[i] changes only to a command that is threshold_rad or more away from it",
    "quantization": "data.ctrl[i] = origin_rad + step_rad * round((command - origin_rad) / step_rad)",
    "servo_gain": "data.ctrl[i] = gain * command",
    "servo_nonlinearity": "data.ctrl[i] = command (1 + slope) + curvature_per_rad / 2 command^2 + "
    "third_order_per_rad2 / 3 command^3 + sine_rad sin(cycles_per_turn command) + "
    "cosine_rad cos(cycles_per_turn command)",
    "thermal_drift": "data.ctrl[i] = command + the drift by then",
    "missed_command": "data.ctrl[i] stays as it is at the rows samples",
    "joint_slip": "from from_s on the encoder of the joint reads jump_rad more",
    "outliers": "single readings are off by size_rad",
    "payload": "a mass at the tip that the loops do not carry: see payload_compliance_rad_per_nm",
}


@dataclass(frozen=True)
class MovingHeld:
    """What an exported file holds of a moving twin, and what it does not, each with what makes it."""

    held: tuple[MotionCause, ...]
    not_held: tuple[tuple[MotionCause, str], ...]


def export_moving_mjcf(
    causes: Sequence[MotionCause], arm: MotionArm, path: Path, zeros_rad: Array | None = None
) -> MovingHeld:
    """Write `path` (MJCF) and beside it `<stem>.armtwin.json`; returns what the file holds.

    Raises `InputError` as `inject_in_motion` does.
    """
    bare = ideal_motion_world(arm, zeros_rad)
    held: list[MotionCause] = []
    not_held: list[tuple[MotionCause, str]] = []
    world = bare
    for cause in causes:
        name, site, parameters = cause
        why = _beyond_a_file(bare, inject_in_motion(bare, name, parameters, site), name)
        world = inject_in_motion(world, name, parameters, site)
        if why is None:
            held.append(cause)
        else:
            not_held.append((cause, why))
    with building():
        spec = _numbered(world)
        spec.comment = _comment(held, not_held)
        spec.compile()
    atomic.write_text(path, spec.to_xml())
    atomic.write_json(note_beside(path), _note(path.name, world, held, not_held))
    return MovingHeld(tuple(held), tuple(not_held))


def _numbered(world: MotionWorld) -> Any:
    """Return the model with the numbers of drives that follow nothing."""
    bank = DriveBank(tuple(_still(drive) for drive in world.drives), world.servo.stiffness_nm_rad)
    spec = motion_spec(world, bank.has_friction)
    damping, armature = bank.step(LONGEST_STEP_S)
    nothing = np.zeros(len(damping))
    friction = bank.friction(nothing, nothing, nothing)
    for i, name in enumerate(world.arm.joints):
        joint = spec.joint(name)
        joint.damping[0], joint.armature, joint.frictionloss = damping[i], armature[i], friction[i]
        spec.actuator(drive_name(name)).forcerange = bank.push_limits(damping, nothing, friction)[i]
    return spec


def _still(drive: Drive) -> Drive:
    """Return the drive without what follows its load or its speed."""
    none = Drive(drive.time_constant_s, drive.speed_rad_s)
    return replace(drive, **{name: getattr(none, name) for name in _AT_EVERY_STEP})


def _beyond_a_file(bare: MotionWorld, alone: MotionWorld, name: str) -> str | None:
    """Say what makes the part of an effect that no file holds, or None."""
    for ours, theirs in zip(bare.drives, alone.drives, strict=True):
        for part, what in _AT_EVERY_STEP.items():
            if getattr(ours, part) != getattr(theirs, part):
                return what
    beyond = ("wiring", "slips", "disturbances", "readings", "payload_kg")
    if any(getattr(bare, part) != getattr(alone, part) for part in beyond):
        return _ON_THE_WIRE.get(name, "acts on commands or readings, beyond the arm")
    return None


def _note(
    file: str, world: MotionWorld, held: Sequence[MotionCause], not_held: Sequence[tuple[MotionCause, str]]
) -> dict[str, Any]:
    return {
        "schema": SCHEMA,
        "format": "mjcf",
        "motion": "moving",
        "file": file,
        "timestep_s": LONGEST_STEP_S,
        "stiffness_nm_rad": STIFFNESS_NM_RAD,
        "joints": [
            {
                "joint": i + 1,
                "name": name,
                "actuator": drive_name(name),
                "encoder": [name, *_behind(world, i)],
                "zero_rad": zero,
            }
            for i, (name, zero) in enumerate(zip(world.arm.joints, world.zeros_rad.tolist(), strict=True))
        ],
        "held": [_table(cause) for cause in held],
        "not_held": [{**_table(cause), "recipe": recipe} for cause, recipe in not_held],
    }


def _behind(world: MotionWorld, index: int) -> tuple[str, ...]:
    return world.series_hinges.get(index, ())


def _table(cause: MotionCause) -> dict[str, Any]:
    name, site, parameters = cause
    return {"effect": name, "joint": site.joint, "parameters": dict(parameters)}


def _comment(held: Sequence[MotionCause], not_held: Sequence[tuple[MotionCause, str]]) -> str:
    lines = [
        "A moving twin measured and exported by armtwin. Actuator drive_NAME takes the command of joint NAME in rad.",
        f"Keep the time step of {LONGEST_STEP_S} s: armature and damping are made for it. The drives are so stiff that",
        "links bend nothing; friction, stops and rotors are in proportion. An encoder reads its joint and the gap",
        "behind it.",
        *(f"holds {name} ({site}): {dict(parameters)}" for name, site, parameters in held),
        *(
            f"does not hold {name} ({site}): {dict(numbers)}; make it so: {how}"
            for (name, site, numbers), how in not_held
        ),
    ]
    return "\n".join(lines).replace("--", "- -")  # no XML comment may hold two hyphens in a row
