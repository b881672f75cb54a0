"""Faults that no effect of the catalogue describes, made physically: the diagnosis has to say `unknown`.

Mechanical ones in space (a cable, a shared supply, coupled joints) and in time (links that breathe, a zero that
wanders, a sticker that peels), optical ones in space (a pane of glass before part of the picture) and in time (a
camera that swings).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from armtwin.models.camera import Camera
from armtwin.models.errors import JobError
from armtwin.models.mjcf import add_spring
from armtwin.models.units import M_PER_MM
from armtwin.models.world import Command, Electronics, Event, Moment, World
from armtwin.sim.sealed import STRENGTHS, Sealed, Strength, bench_of, moved_px, record, scale, truth_of

Array = NDArray[np.float64]
Fault = Callable[[World, float, Generator], World]

# Longest recording for which things that go on during it are made.
_MOST_POSES = 600
_ATTEMPTS = 12


def cable(world: World, amplitude: float, rng: Generator) -> World:
    """A cable from a post to the second link, slack when short, pulls on joints that give (`amplitude` N/m)."""
    post, slack = rng.uniform([-0.02, 0.12], [0.06, 0.17]), float(rng.uniform(0.09, 0.12))

    def mechanism(spec: mujoco.MjSpec) -> None:
        for joint in range(1, world.arm.n_joints + 1):
            add_spring(spec, joint, f"give{joint}", 0.05)
        spec.worldbody.add_site(name="post", pos=[*post, 0.0])
        spec.body("link2").add_site(name="clip", pos=[0.09, 0.0, 0.0])
        tendon = spec.add_tendon(name="cable")
        tendon.wrap_site("post")
        tendon.wrap_site("clip")
        tendon.stiffness[0] = amplitude
        tendon.springlength = [0.0, slack]

    hinges = tuple(f"give{joint}" for joint in range(1, world.arm.n_joints + 1))
    return world.with_mechanism(mechanism, relieved=hinges)


def shared_supply(world: World, amplitude: float, rng: Generator) -> World:
    """A large step of joint 2 pulls the supply down, and joint 3 falls short by up to `amplitude` rad."""
    knee = float(rng.uniform(0.03, 0.1))

    def board() -> Electronics:
        before: float | None = None

        def receive(command: Command) -> Array:
            nonlocal before
            step = 0.0 if before is None else abs(float(command.q[1]) - before)
            before = float(command.q[1])
            q = command.q.copy()
            q[2] -= amplitude * np.tanh((step / knee) ** 2)
            return q

        return receive

    return world.with_electronics(board)


def coupled_joints(world: World, amplitude: float, rng: Generator) -> World:
    """A tendon over the elbow turns joint 3 by a bent function of joint 2's angle (`amplitude` rad)."""
    turns, phase = float(rng.uniform(3.0, 6.0)), float(rng.uniform(-np.pi, np.pi))

    def linkage() -> Electronics:
        def receive(command: Command) -> Array:
            q = command.q.copy()
            q[2] += amplitude * np.sin(turns * command.q[1] + phase)
            return q

        return receive

    return world.with_electronics(linkage)


def breathing_link(world: World, amplitude: float, rng: Generator) -> World:
    """The second link grows and shrinks by `amplitude` mm as the room warms and cools."""
    period, phase = float(rng.uniform(25.0, 60.0)), float(rng.uniform(-np.pi, np.pi))

    def stretch(sample: int) -> Callable[[mujoco.MjModel, mujoco.MjData], None]:
        def happen(model: mujoco.MjModel, data: mujoco.MjData) -> None:
            swing = [np.sin(2 * np.pi * s / period + phase) for s in (sample, sample - 1)]
            grown = swing[0] - (swing[1] if sample else 0.0)
            model.body("end2").pos[0] += amplitude * M_PER_MM * grown

        return happen

    for sample in range(_MOST_POSES):
        world = world.with_event(Event(sample, stretch(sample)))
    return world


def wandering_zero(world: World, amplitude: float, rng: Generator) -> World:
    """Joint 2's zero wanders to and fro, by up to about `amplitude` rad, as a loose potentiometer's does."""
    periods = rng.uniform([15.0, 30.0], [30.0, 70.0])
    phases = rng.uniform(-np.pi, np.pi, 2)

    def board() -> Electronics:
        def receive(command: Command) -> Array:
            q = command.q.copy()
            q[1] += 0.6 * amplitude * float(np.sin(2 * np.pi * command.sample / periods + phases).sum())
            return q

        return receive

    return world.with_electronics(board)


def peeling_sticker(world: World, amplitude: float, rng: Generator) -> World:
    """Marker C's sticker slides off, back and off again over the recording, by up to `amplitude` mm."""
    period = float(rng.uniform(40.0, 80.0))
    direction = rng.uniform(-np.pi, np.pi)
    along = amplitude * M_PER_MM * np.array([np.cos(direction), np.sin(direction), 0.0])

    def slide(sample: int) -> Callable[[mujoco.MjModel, mujoco.MjData], None]:
        def happen(model: mujoco.MjModel, data: mujoco.MjData) -> None:
            sticker = model.site("marker_c")
            sticker.sameframe = 0  # MuJoCo takes a site that was compiled at its body's origin to stay there
            sticker.pos = along * np.sin(2 * np.pi * sample / period)

        return happen

    for sample in range(_MOST_POSES):
        world = world.with_event(Event(sample, slide(sample)))
    return world


def swinging_camera(world: World, amplitude: float, rng: Generator) -> World:
    """The camera swings on its arm by up to `amplitude` rad, slowly enough for sharp pictures."""
    period, phase = float(rng.uniform(6.0, 25.0)), float(rng.uniform(-np.pi, np.pi))
    axis = rng.standard_normal(3)
    axis /= np.linalg.norm(axis)

    def swing(camera: Camera, moment: Moment) -> Camera:
        angle = amplitude * np.sin(2 * np.pi * moment.sample / period + phase)
        return camera.moved(Rotation.from_rotvec(angle * axis).as_matrix(), np.zeros(3))

    return world.with_camera_motion(swing)


def pane_of_glass(world: World, amplitude: float, rng: Generator) -> World:
    """A pane with a wedge before part of the picture: what is behind it is shifted by up to `amplitude` px."""
    edge, width = float(rng.uniform(420.0, 640.0)), float(rng.uniform(10.0, 60.0))
    direction = rng.uniform(-np.pi, np.pi)
    shift = np.array([np.cos(direction), np.sin(direction)])

    def refract(pixels: dict[str, Array], rng: Generator) -> dict[str, Array]:
        behind = {name: 0.5 * (1 + np.tanh((edge - p[:, :1]) / width)) for name, p in pixels.items()}
        thicker = {name: 1.0 + 0.5 * np.sin(p[:, 1:] / 60.0) for name, p in pixels.items()}
        return {name: p + amplitude * behind[name] * thicker[name] * shift for name, p in pixels.items()}

    return world.with_detection(refract)


@dataclass(frozen=True)
class Kind:
    """A fault, the amplitude from which it is scaled, and its largest one."""

    fault: Fault
    start: float
    most: float


UNCATALOGUED: dict[str, Kind] = {
    "cable": Kind(cable, 5.0, 200.0),
    "shared_supply": Kind(shared_supply, 0.02, 0.3),
    "coupled_joints": Kind(coupled_joints, 0.01, 0.3),
    "breathing_link": Kind(breathing_link, 1.0, 15.0),
    "wandering_zero": Kind(wandering_zero, 0.01, 0.2),
    "peeling_sticker": Kind(peeling_sticker, 1.0, 10.0),
    "swinging_camera": Kind(swinging_camera, 0.002, 0.03),
    "pane_of_glass": Kind(pane_of_glass, 1.0, 30.0),
}


def draw_uncatalogued(rng: Generator, name: str, strength: Strength = "medium", n_poses: int | None = None) -> Sealed:
    """Draw a world with one of these faults, scaled as `armtwin.sim.sealed.draw_world` scales the catalogue's.

    All markers of the arm are looked for; raises `JobError` where no draw moves them far enough.
    """
    kind = UNCATALOGUED[name]
    low, high = STRENGTHS[strength]
    for _ in range(_ATTEMPTS):
        bench, scene = bench_of(rng, (), n_poses=n_poses, markers=("a", "b", "c", "f"))
        target = scene.noise_px * float(np.exp(rng.uniform(np.log(low * 1.1), np.log(high))))
        seed = int(rng.integers(2**32))

        def world_of(amplitude: float, bench: World = bench, seed: int = seed) -> World:
            return kind.fault(bench, amplitude, np.random.default_rng(seed))

        amplitude, moved = scale(lambda a: moved_px(scene, world_of(a), seed), kind.start, kind.most, target)  # noqa: B023
        if moved >= low * scene.noise_px:
            world = world_of(amplitude)
            hidden = {
                "effect": name,
                "joint": None,
                "marker": None,
                "parameters": {"amplitude": amplitude},
                "moved_px": moved,
                "moved_noises": moved / scene.noise_px,
            }
            return Sealed(record(rng, world, scene), truth_of(world, scene, [hidden], strength), world)
    raise JobError(f"no world in {_ATTEMPTS} draws in which {name} moves the markers at '{strength}'")
