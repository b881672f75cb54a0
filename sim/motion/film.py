"""A moving arm filmed: exposed for a while, so that what moves meanwhile is blurred.

    | exposure, centred on its row's time |        the row's command is given at that time and acts from then on

A picture is the mean of the light at moments spread over the exposure, no further than half a pixel of way apart.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import mujoco
import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from armtwin.models.bench import Frame
from armtwin.models.camera import project
from armtwin.models.coordinate_frames import robot_to_board
from armtwin.models.motion_world import MotionWorld
from armtwin.models.units import MM_PER_M
from armtwin.models.world import World
from armtwin.sim.arm_view import arm_scene, bodies_in_robot, bodies_on_board
from armtwin.sim.motion.simulation import MotionRun
from armtwin.sim.physics.placements import placements
from armtwin.sim.render import LensRenderer, Part
from armtwin.sim.sensor import Sensor, expose

Array = NDArray[np.float64]

# A disc that is drawn at places this far apart looks evenly smeared once the lens has blurred it.
_STEP_PX = 0.5
_MOST_MOMENTS = 15


class FilmedArm:
    """A moving arm as the renderer and the camera see it: `world` says what it looks like, `moving` how it moves."""

    def __init__(self, world: World, moving: MotionWorld, time_s: Array, q_cmd: Array) -> None:
        self.world = world
        self._run = MotionRun(moving, time_s, q_cmd)
        self.model = self._run.model
        self.marker_names = world.arm.known_markers
        self._sites = [self.model.site(f"marker_{name}").id for name in self.marker_names]

    def advance_to(self, time_s: float) -> None:
        """Let the arm move until `time_s`."""
        self._run.advance_to(time_s)
        mujoco.mj_kinematics(self.model, self._run.data)

    def bodies(self) -> dict[str, Array]:
        """(4, 4) placement of each body in the robot frame, mm."""
        return placements(self.model, self._run.data)

    def pixels(self) -> Array:
        """(M, 2) where the markers' centres truly are in the picture, px, in the order of `marker_names`."""
        points = self._run.data.site_xpos[self._sites] * MM_PER_M
        return project(self.world.true_camera, robot_to_board(points, self.world.base_in_board_mm))


class Film:
    """Pictures of a moving arm at the times of its commands; the same seed gives the same pictures."""

    def __init__(
        self, arm: FilmedArm, sensor: Sensor, rng: Generator, *, shadows: bool = True, obstacles: Sequence[Part] = ()
    ) -> None:
        self._arm = arm
        self._sensor = sensor
        self._rng = rng
        self._renderer = LensRenderer(arm.world.true_camera, [*arm_scene(arm), *obstacles], shadows=shadows)
        self._pixels = arm.pixels()

    def frame(self, time_s: float) -> Frame:
        """Take the picture whose exposure has its middle at `time_s`, at which the next command is given."""
        half = 0.5 * self._sensor.exposure_time_s
        self._arm.advance_to(time_s - half)
        shown, at = [bodies_in_robot(self._arm)], [self._arm.pixels()]
        for moment in np.linspace(time_s - half, time_s + half, _MOST_MOMENTS)[1:] if half else ():
            self._arm.advance_to(float(moment))
            shown.append(bodies_in_robot(self._arm))
            at.append(self._arm.pixels())
        self._pixels = np.mean(at, axis=0)
        way = float(np.linalg.norm(np.diff(at, axis=0), axis=-1).sum(axis=0).max()) if len(at) > 1 else 0.0
        wanted = int(np.clip(np.ceil(way / _STEP_PX) + 1, 1, _MOST_MOMENTS))
        chosen = np.unique(np.round((np.arange(wanted) + 0.5) / wanted * len(shown) - 0.5).astype(int))
        light = np.zeros((1, 1, 3), np.float32)
        for k, number in enumerate(chosen):
            one = self._renderer.render_linear(bodies_on_board(self._arm.world, shown[number]))
            light = one.copy() if k == 0 else light + one
        image = expose(np.asarray(light / len(chosen), np.float32), self._sensor, self._rng)
        return Frame(image, time_s, time_s)

    def true_pixels(self) -> dict[str, Array]:
        """Where the markers' centres truly were, on the mean over the last exposure, (2,) px by name."""
        return dict(zip(self._arm.marker_names, self._pixels, strict=True))

    def close(self) -> None:
        """Free the renderer."""
        self._renderer.close()


def filmed(film: Film, time_s: Array) -> Iterator[Frame]:
    """Yield the pictures at (N,) times, and free the renderer at the end."""
    try:
        for moment in time_s:
            yield film.frame(float(moment))
    finally:
        film.close()
