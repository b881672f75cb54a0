"""Draw a sealed world: a true bench, a plan, and effects scaled to move the markers by a multiple of the noise."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from armtwin.models.arm import Arm, nominal_arm
from armtwin.models.camera import Camera
from armtwin.models.camera_files import nominal_camera
from armtwin.models.catalogue.registry import catalogue, effect_named
from armtwin.models.catalogue.sealed import Hidden, Sealing
from armtwin.models.errors import InputError, JobError
from armtwin.models.kinematics import Deviation
from armtwin.models.plan import Plan
from armtwin.models.recordings.recording import Recording
from armtwin.models.recordings.writer import camera_table
from armtwin.models.world import World, ideal_world
from armtwin.sim.observe import make_recording
from armtwin.sim.sealed.displacement import Scene, moved_px
from armtwin.sim.sealed.plans import draw_plan

Array = NDArray[np.float64]
Strength = Literal["weak", "medium", "strong"]

# How far the markers move, beyond what geometry takes up, in multiples of the noise of a pixel coordinate.
STRENGTHS: dict[Strength, tuple[float, float]] = {"weak": (3.0, 6.0), "medium": (6.0, 15.0), "strong": (15.0, 40.0)}
# The built arm against its drawing: what a ruler and a horn's spline (25 teeth: 14.4 degrees) leave.
_LENGTH_ERROR_MM = 6.0
_SHORT_LENGTH_ERROR_MM = 1.5
_ZERO_ERROR_RAD = np.radians(6.0)
# Noise of a marker's centre: from a good sub-pixel detector to a poor one, px.
_NOISE_PX = (0.03, 0.3)
_GRAVITY_M_S2 = 9.81
# The arm's base stands at the lower right of the picture, so that its links reach over all of it.
_BASE_MM = (40.0, -33.0)
_BASE_SPREAD_MM = 6.0
_ARM_PLANE_MM = -80.87
_SCALINGS = 4
_CLOSE_ENOUGH = 0.2
_ATTEMPTS = 12
# Share of the recordings that declare their noise.
_DECLARED = 0.7


@dataclass(frozen=True, eq=False)
class Sealed:
    """A recording, the truth about it as plain data, and the world that it was made in."""

    recording: Recording
    truth: dict[str, Any]
    world: World


@dataclass(frozen=True, eq=False)
class _Found:
    """An effect scaled to its strength: how far it moves the markers, px, and the world with it alone."""

    name: str
    hidden: Hidden
    amplitude: float
    moved_px: float
    alone: World


def draw_world(
    rng: Generator,
    effects: str | Sequence[str] | None = None,
    strength: Strength = "medium",
    *,
    arm: Arm | None = None,
    n_poses: int | None = None,
    noise_px: float | None = None,
    markers: Sequence[str] | None = None,
    missing: float | None = None,
) -> Sealed:
    """Draw a world with no effect, one effect (its name) or several (names) hidden in it, and record it.

    What is None is drawn: 120 to 260 poses, a noise of 0.03 to 0.3 px, all markers (or A and F alone in one of
    eight worlds, as in the paper), up to 3 % of the sightings missing. Raises `InputError` for an unknown effect and
    `JobError` where no draw moves the markers as far as `strength` says.
    """
    names = () if effects is None else (effects,) if isinstance(effects, str) else tuple(effects)
    for name in names:
        sealing_of(name)
    for _ in range(_ATTEMPTS):
        bench, scene = bench_of(rng, names, arm, n_poses, noise_px, markers)
        lost = float(rng.choice([0.0, rng.uniform(0.0, 0.03)])) if missing is None else missing
        hidden = [_scaled(name, rng, bench, scene, strength) for name in names]
        if all(found is not None for found in hidden):
            return _record(rng, bench, scene, [found for found in hidden if found is not None], strength, lost)
    raise JobError(f"no world in {_ATTEMPTS} draws in which {' and '.join(names)} moves the markers at '{strength}'")


def bench_of(
    rng: Generator,
    names: Sequence[str],
    arm: Arm | None = None,
    n_poses: int | None = None,
    noise_px: float | None = None,
    markers: Sequence[str] | None = None,
    given: tuple[Plan, tuple[str, ...]] | None = None,
    camera: Camera | None = None,
) -> tuple[World, Scene]:
    """Draw a true bench without effects, fit for `names`, and the scene: what is done and looked for on it.

    `given` are a plan and the names of its held-out trajectories, where none is to be drawn; the camera is
    the nominal one unless given.
    """
    hiding = [sealing_of(name) for name in names]
    declared = nominal_arm() if arm is None else arm
    if arm is None and (any(how.in_gravity for how in hiding) or rng.random() < 0.5):
        declared = replace(declared, gravity_m_s2=np.array([0.0, -_GRAVITY_M_S2]))
    spread = np.where(declared.link_lengths_mm > 20.0, _LENGTH_ERROR_MM, _SHORT_LENGTH_ERROR_MM)
    deviation = Deviation(
        rng.uniform(-spread, spread), rng.uniform(-_ZERO_ERROR_RAD, _ZERO_ERROR_RAD, declared.n_joints)
    )
    base = np.array(_BASE_MM) + rng.uniform(-_BASE_SPREAD_MM, _BASE_SPREAD_MM, 2)
    seen_by = nominal_camera() if camera is None else camera
    world = ideal_world(declared, seen_by, _ARM_PLANE_MM, base, deviation)
    if given is None:
        given = draw_plan(rng, declared, int(rng.integers(120, 261)) if n_poses is None else n_poses)
    plan, held_out = given
    period = rng.uniform(1.0, 3.0)
    timed = any(how.timed for how in hiding) or rng.random() < 0.8
    noise = float(np.exp(rng.uniform(*np.log(_NOISE_PX)))) if noise_px is None else noise_px
    if markers is None:
        tip_only = rng.random() < 0.125 and not any(how.all_markers for how in hiding)
        markers = (declared.marker_names[0], declared.marker_names[-1]) if tip_only else declared.marker_names
    world = replace(world, pose_period_s=period)
    return world, Scene(world, plan, held_out, period, timed, noise, tuple(markers))


def hide(world: World, name: str, hidden: Hidden, amplitude: float) -> World:
    """Return the world with effect `name` of an amplitude in it."""
    inject = effect_named(name).inject
    return inject(world, hidden.parameters(amplitude), hidden.site)


def sealing_of(name: str) -> Sealing:
    """Return how an effect is hidden; raises `InputError` for one that is unknown, or that says nothing of it."""
    sealing = effect_named(name).sealed
    if sealing is None:
        raise InputError(f"effect '{name}' does not say how it is hidden in a sealed world: its `sealed` is wanted")
    return sealing


def sealed_effects() -> tuple[str, ...]:
    """Return the names of the effects that can be hidden."""
    return tuple(name for name, effect in catalogue().items() if effect.sealed is not None)


def _scaled(name: str, rng: Generator, bench: World, scene: Scene, strength: Strength) -> _Found | None:
    """Draw an effect and scale it; None where it stays too small."""
    low, high = STRENGTHS[strength]
    target = scene.noise_px * float(np.exp(rng.uniform(np.log(low * 1.1), np.log(high))))
    hidden = sealing_of(name).draw(rng, scene.situation(target))
    seed = int(rng.integers(2**32))

    tried = [bench]

    def measure(a: float) -> float:
        tried[0] = hide(bench, name, hidden, a)
        return moved_px(scene, tried[0], seed, beyond_geometry=effect_named(name).gauge is None)

    amplitude, moved = scale(measure, hidden.start, hidden.most, target)
    return _Found(name, hidden, amplitude, moved, tried[0]) if moved >= low * scene.noise_px else None


def scale(measure: Callable[[float], float], start: float, most: float, target: float) -> tuple[float, float]:
    """Find an amplitude, from `start` up to `most`, of which `measure` is about `target`: (amplitude, its measure)."""
    amplitude, found = start, measure(start)
    for _ in range(_SCALINGS):
        if abs(np.log(max(found, 1e-12) / target)) < _CLOSE_ENOUGH:
            break
        wanted = min(amplitude * float(np.clip(target / max(found, 1e-12), 0.02, 50.0)), most)
        if wanted == amplitude:
            break
        amplitude, found = wanted, measure(wanted)
    return amplitude, found


def _record(
    rng: Generator,
    bench: World,
    scene: Scene,
    found: Sequence[_Found],
    strength: Strength,
    missing: float,
) -> Sealed:
    world = found[0].alone if found else bench  # that which was looked at last, so that it is not simulated again
    for one in found[1:]:
        world = hide(world, one.name, one.hidden, one.amplitude)
    effects = [
        {
            "effect": one.name,
            "joint": one.hidden.site.joint,
            "marker": one.hidden.site.marker,
            "parameters": plain(one.hidden.parameters(one.amplitude)),
            "moved_px": one.moved_px,
            "moved_noises": one.moved_px / scene.noise_px,
        }
        for one in found
    ]
    recording = record(rng, world, scene, missing)
    return Sealed(recording, truth_of(world, scene, effects, strength if found else None), world)


def record(
    rng: Generator, world: World, scene: Scene, missing: float = 0.0, declare_noise: bool | None = None
) -> Recording:
    """Record a world on a scene, with its noise, and with a share `missing` of the sightings lost.

    Whether the noise is declared is drawn where it is None.
    """
    plan = scene.plan
    declared = bool(rng.random() < _DECLARED) if declare_noise is None else declare_noise
    return make_recording(
        world,
        plan.q_cmd,
        plan.trajectory,
        scene.clock if scene.timed else None,
        rng,
        scene.noise_px,
        truth_px=scene.pixels(world),
        held_out=scene.held_out,
        markers=scene.markers,
        missing=missing,
        declare_noise=declared,
    )


def plain(parameters: dict[str, Any]) -> dict[str, Any]:
    """Return parameters without NumPy's scalars."""
    return {name: value.item() if isinstance(value, np.generic) else value for name, value in parameters.items()}


def truth_of(world: World, scene: Scene, effects: list[dict[str, Any]], strength: str | None) -> dict[str, Any]:
    """Return the truth about a world as plain data, with the keys of `truth.json`."""
    return {
        "link_lengths_mm": (world.arm.link_lengths_mm + world.deviation.lengths_mm).tolist(),
        "joint_offsets_rad": world.deviation.joints_rad.tolist(),
        "camera": camera_table(world.true_camera),
        "arm_plane_z_mm": float(world.base_in_board_mm[2]),
        "base_in_board_mm": world.base_in_board_mm.tolist(),
        "effects": effects,
        "strength": strength,
        "noise_px": scene.noise_px,
        "n_poses": len(scene.plan),
    }
