"""The arm of a world as it is drawn: shaped by what is true of it, placed where the physics has it."""

from __future__ import annotations

from typing import Protocol

import mujoco
import numpy as np
from numpy.typing import NDArray

from armtwin.models.units import MM_PER_M
from armtwin.models.world import World
from armtwin.sim.render import Part, arm_parts, clutter_parts, panel_parts, robot_bodies_on_board

Array = NDArray[np.float64]


class Shown(Protocol):
    """An arm that stands somewhere: of poses at rest, or on its way."""

    @property
    def world(self) -> World:
        """What it truly looks like."""

    @property
    def model(self) -> mujoco.MjModel:
        """Its model, with the stickers' places."""

    def bodies(self) -> dict[str, Array]:
        """(4, 4) placement of each body in the robot frame, mm."""


def backdrop(world: World) -> list[Part]:
    """Return what stands behind and beside the arm: the panel and the usual clutter."""
    return [*panel_parts(), *clutter_parts(world.base_in_board_mm)]


def arm_scene(arm: Shown) -> list[Part]:
    """Return the arm before its backdrop: true lengths, and each sticker where and on what it truly is."""
    world, model = arm.world, arm.model
    lengths = world.arm.link_lengths_mm + world.deviation.lengths_mm
    parts = backdrop(world)
    for part in arm_parts(lengths, n_joints=world.arm.n_joints):
        if part.name.startswith("marker "):
            site = model.site(f"marker_{part.name.removeprefix('marker ')}")
            at = np.eye(4)
            at[:3, 3] = np.asarray(site.pos) * MM_PER_M
            body = model.body(int(site.bodyid[0])).name
            part = part.on("base" if body == "world" else body, at)
        parts.append(part)
    return parts


def bodies_in_robot(arm: Shown) -> dict[str, Array]:
    """(4, 4) placement of each body of `arm_scene` in the robot frame, mm, where the physics has it now."""
    return {"base": np.eye(4), **arm.bodies()}


def bodies_on_board(world: World, bodies: dict[str, Array]) -> dict[str, Array]:
    """Carry (4, 4) placements from the robot frame to the board frame, in which the renderer draws."""
    return robot_bodies_on_board(bodies, world.base_in_board_mm)
