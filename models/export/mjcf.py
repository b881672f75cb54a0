"""A twin as an MJCF file that plain MuJoCo loads and that moves as the twin moves.

The file holds the arm as it stood at the end of the recording: a horn that slipped has slipped, a mass that was hung
hangs. Actuator `servo{i}` takes joint i's command, rad; site `marker_f` (or the last letter) is the tip.

Two things of the simulated bench are no part of a file, and made otherwise in it. The integral part of the servos,
which takes out their droop, works between poses; in the file the servos are `STIFFER` times stiffer and heavier
instead, so that no load moves them. A fraction of the command that a servo turns is its actuator's gear.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from armtwin.models import atomic
from armtwin.models.catalogue.registry import effect_named
from armtwin.models.export.held import SCHEMA, Held, effect_table, effects_held, label
from armtwin.models.twin import Twin, TwinEffect, rebuild
from armtwin.models.world import World

# A droop of 1 mrad becomes one of 0.01 mrad. Rotor and damping grow alike, so that the loop is as quick as before and
# stops and dry friction, which MuJoCo resolves by the inertias, still outweigh it.
STIFFER = 100.0


def mjcf_spec(twin: Twin) -> tuple[mujoco.MjSpec, Held]:
    """Return the model of a twin's arm, and which effects it holds; raises `InputError` for an arm none can build."""
    held = effects_held(twin, gears=True)
    world = rebuild(twin)
    spec = world.spec()
    spec.modelname = f"{twin.arm.name} (armtwin twin)"
    if world.waits_for_rest:
        _stiffen(spec, world)
    for effect in held.held:
        gear = effect_named(effect.effect).as_gear
        if gear is not None:
            _gear(spec, effect, float(effect.parameters[gear]))
    balanced = bool(world.relieved) and bool(np.any(world.arm.gravity_m_s2))
    if balanced:
        _balance(spec)
    _let_happen(spec, world)
    spec.comment = _comment(held, balanced)
    return spec, held


def export_mjcf(twin: Twin, path: Path) -> Held:
    """Write `path` (MJCF) and beside it `<stem>.armtwin.json`, what the file holds of the twin and what it does not.

    Plain `mujoco.MjModel.from_xml_path` loads it: no meshes, no plugins. Returns which effects are held.
    """
    spec, held = mjcf_spec(twin)
    spec.compile()
    atomic.write_text(path, spec.to_xml())
    atomic.write_json(note_beside(path), note_of(twin, held, "mjcf", path.name))
    return held


def note_beside(path: Path) -> Path:
    """Return the file beside an exported model that says what it does not hold."""
    return path.with_name(f"{path.stem}.armtwin.json")


def note_of(twin: Twin, held: Held, form: str, name: str) -> dict[str, Any]:
    """Return the content of that file (`armtwin.export/1`)."""
    return {
        "schema": SCHEMA,
        "format": form,
        "file": name,
        "link_lengths_mm": twin.arm.link_lengths_mm + twin.deviation.lengths_mm,
        "joint_zeros_rad": twin.deviation.joints_rad,
        "held": [effect_table(effect) for effect in held.held],
        "not_held": [{**effect_table(one.effect), "why": one.why} for one in held.not_held],
    }


def _stiffen(spec: mujoco.MjSpec, world: World) -> None:
    for number in range(1, world.arm.n_joints + 1):
        actuator, joint = spec.actuator(f"servo{number}"), spec.joint(f"joint{number}")
        for parameters in (actuator.gainprm, actuator.biasprm):
            parameters[:] = np.asarray(parameters) * STIFFER
        actuator.forcerange = np.asarray(actuator.forcerange) * STIFFER
        joint.armature = float(joint.armature) * STIFFER


def _gear(spec: mujoco.MjSpec, effect: TwinEffect, gain: float) -> None:
    """Let the servo's loop see 1 / gain of the angle, so that it stops at gain times the command."""
    actuator = spec.actuator(f"servo{effect.joint}")
    gear = np.array(actuator.gear)
    gear[0] = gear[0] / gain
    actuator.gear = gear


def _balance(spec: mujoco.MjSpec) -> None:
    """Carry the arm's own weight: MuJoCo's gravity compensation stands for the balance of the simulated bench."""
    for body in spec.bodies:
        if body.name != "world":
            body.gravcomp = 1.0


def _let_happen(spec: mujoco.MjSpec, world: World) -> None:
    if not world.events:
        return
    model = spec.compile()
    data = mujoco.MjData(model)
    for event in sorted(world.events, key=lambda event: event.sample):
        event.happen(model, data)
    mujoco.mj_setConst(model, data)
    spec.copy_back(model)


def _comment(held: Held, balanced: bool) -> str:
    lines = [
        "A twin measured and exported by armtwin, as it stood at the end of its recording. Actuator servoN takes the",
        "command of joint N in rad. The servos are so stiff that no load moves them: what gives, gives behind them.",
    ]
    if balanced:
        lines.append("The arm's weight is balanced (gravcomp): nothing sags by it.")
    lines += [f"holds {label(effect)}: {dict(effect.parameters)}" for effect in held.held]
    lines += [
        f"does not hold {label(one.effect)}, which {one.why}: {dict(one.effect.parameters)}" for one in held.not_held
    ]
    return "\n".join(lines).replace("--", "- -")  # no XML comment may hold two hyphens in a row
