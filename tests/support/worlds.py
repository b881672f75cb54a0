"""Worlds and commands for tests of the simulated bench."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from armtwin.models.arm import nominal_arm
from armtwin.models.camera_files import nominal_camera
from armtwin.models.catalogue.registry import Site, effect_named
from armtwin.models.kinematics import Deviation
from armtwin.models.world import World, ideal_world
from armtwin.sim.physics.simulation import ArmSimulation

Array = NDArray[np.float64]

PLANE_MM = -80.87
# Marker A at the lower right of the picture, so that the whole arm is in it.
BASE_MM = np.array([40.0, -33.0])


def flat_world(deviation: Deviation | None = None) -> World:
    """Return the nominal bench with the arm lying flat: no gravity in its plane."""
    return ideal_world(nominal_arm(), nominal_camera(), PLANE_MM, BASE_MM, deviation)


def upright_world(deviation: Deviation | None = None) -> World:
    """Return the nominal bench with the arm standing upright."""
    arm = replace(nominal_arm(), gravity_m_s2=np.array([0.0, -9.81]))
    return ideal_world(arm, nominal_camera(), PLANE_MM, BASE_MM, deviation)


def small_camera(world: World) -> World:
    """Return the world seen by a camera of a quarter of the pixels, which is drawn faster."""
    K = world.camera.K.copy()
    K[:2] *= 0.5
    camera = replace(world.camera, image_width=640, image_height=360, K=K)
    return replace(world, camera=camera, true_camera=camera)


def with_effect(
    world: World, name: str, parameters: dict[str, Any], joint: int | None = None, marker: str | None = None
) -> World:
    """Return the world with a catalogued effect in it."""
    made: World = effect_named(name).inject(world, parameters, Site(joint, marker))
    return made


def errors_rad(world: World, q_cmd: Array, time_s: Array | None = None) -> Array:
    """(N, n) rad by which the links stand off their commands."""
    arm = ArmSimulation(world)
    reached = np.empty_like(q_cmd)
    for sample, q in enumerate(q_cmd):
        arm.move(q, sample, None if time_s is None else float(time_s[sample]))
        reached[sample] = arm.joint_angles()
    return reached - q_cmd


def there_and_back(joint: int, low: float, high: float, n: int) -> Array:
    """(2 n, 3) commands: joint `joint` (from 1) in n even steps from low to high and back, the others at zero."""
    there = np.linspace(low, high, n)
    q = np.zeros((2 * n, 3))
    q[:, joint - 1] = np.concatenate([there, there[::-1]])
    return q


def scattered(n: int, seed: int = 0) -> Array:
    """(n, 3) commands all over the picture."""
    return np.random.default_rng(seed).uniform([-0.4, -0.3, -0.7], [0.3, 0.4, 0.7], (n, 3))
