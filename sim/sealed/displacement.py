"""How far an effect moves the markers in the picture, against the same world without it.

Part of that any geometric calibration takes up: a sag that is the same in all poses is a joint's zero. What counts is
the rest, after lengths, zeros and the base have been fitted to the world with the effect.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from armtwin.models.camera import project
from armtwin.models.catalogue.sealed import Situation
from armtwin.models.coordinate_frames import robot_to_board
from armtwin.models.kinematics import Deviation, marker_positions
from armtwin.models.plan import Plan
from armtwin.models.world import World
from armtwin.sim.observe import pixels_of
from armtwin.sim.physics.simulation import simulate

Array = NDArray[np.float64]

# Rows that an effect moves by less than this share of its most are rows that it does not touch (single events).
_TOUCHED = 0.1
# An effect that shows in a single pose is an anecdote, which no statistics can tell from bad luck.
_FEWEST_TOUCHED = 2


@dataclass(frozen=True, eq=False)
class Scene:
    """What is done on a bench and looked for: its plan, timing, noise and markers.

    Attributes:
        bench: the world without effects.
        plan, held_out: the poses, and the trajectories that are kept for validation.
        period_s: time from pose to pose; recorded only if `timed`.
        noise_px: standard deviation of a pixel coordinate.
        markers: those that are looked for.

    """

    bench: World
    plan: Plan
    held_out: tuple[str, ...]
    period_s: float
    timed: bool
    noise_px: float
    markers: tuple[str, ...]
    _last: list[tuple[World, dict[str, Array]]] = field(default_factory=list, repr=False)

    @property
    def clock(self) -> Array:
        """(N,) times of the poses, s."""
        return np.arange(len(self.plan), dtype=float) * self.period_s

    @cached_property
    def points_mm(self) -> Array:
        """(N, M, 3) markers of the bench without effects, robot frame, mm."""
        return simulate(self.bench, self.plan.q_cmd, self.clock, self.plan.payload_kg)

    @cached_property
    def truth_px(self) -> dict[str, Array]:
        """Pixels of the bench without effects, noise and faults of detection."""
        return pixels_of(self.bench, self.points_mm, self.clock)

    def situation(self, target_px: float) -> Situation:
        """Return what an effect that is to move the markers by `target_px` has to be drawn for."""
        return Situation(self.bench.arm, len(self.plan), float(self.clock[-1]), self.markers, self._steps_px, target_px)

    def _steps_px(self) -> Array:
        """(N,) how far the marker that moves most moves from one pose to the next."""
        seen = np.stack([self.truth_px[name] for name in self.markers], axis=1)
        return np.asarray(np.nanmax(np.linalg.norm(np.diff(seen, axis=0, prepend=seen[:1]), axis=-1), axis=1))

    def pixels(self, world: World) -> dict[str, Array]:
        """Pixels of a world on this scene, before noise and faults of detection; those of the last are kept."""
        if not self._last or self._last[0][0] is not world:
            self._last[:] = [(world, self._seen(world))]
        return dict(self._last[0][1])

    def _seen(self, world: World) -> dict[str, Array]:
        still = all(getattr(world, name) is getattr(self.bench, name) for name in _MOVES_THE_ARM)
        if still and world.picture_lag == self.bench.picture_lag:
            points = self.points_mm
        else:
            points = simulate(world, self.plan.q_cmd, self.clock, self.plan.payload_kg)
        return pixels_of(world, points, self.clock)


# Of the order of the displacements that are looked for; gross errors lie tens of pixels off.
_ROBUST_PX = 3.0
_MOVES_THE_ARM = ("servo", "deviation", "electronics", "mechanics", "events", "waits_for_rest", "bendable", "relieved")


def moved_px(scene: Scene, world: World, seed: int, beyond_geometry: bool = True) -> float:
    """RMS displacement, px, of the marker that an effect moves most, over the poses that it touches.

    An effect that touches too few poses moves nothing. Held-out poses do not count: what shows in them alone nobody is
    asked to find. With `beyond_geometry` what lengths, joint zeros and the base's place can take up is taken off first.
    `seed` is that of the faults of detection, which are drawn.
    """
    seen = {name: points for name, points in scene.pixels(world).items() if name in scene.markers}
    rng = np.random.default_rng(seed)
    for detection in world.detections:
        seen = detection(seen, rng)
    without = _best_geometry(scene, seen) if beyond_geometry else scene.truth_px
    shown = ~np.isin(scene.plan.trajectory, scene.held_out)
    most = 0.0
    for name, points in seen.items():
        distance = np.linalg.norm(points - without[name], axis=1)
        distance = distance[np.isfinite(distance) & shown]
        if not distance.size or distance.max() == 0.0:
            continue
        touched = distance[distance > _TOUCHED * distance.max()]
        if len(touched) >= _FEWEST_TOUCHED:
            most = max(most, float(np.sqrt(np.mean(touched**2))))
    return most


def _best_geometry(scene: Scene, seen: dict[str, Array]) -> dict[str, Array]:
    """Pixels of the geometric model that comes nearest to what is seen, by marker."""
    bench, arm = scene.bench, scene.bench.arm
    n_lengths = len(arm.link_lengths_mm)
    start = np.concatenate([bench.deviation.lengths_mm, bench.deviation.joints_rad, bench.base_in_board_mm[:2]])
    names = [name for name in seen if name in arm.marker_names]
    columns = [arm.marker_names.index(name) for name in names]
    target = np.stack([seen[name] for name in names], axis=1)
    known = np.isfinite(target)

    def predict(x: Array) -> Array:
        deviation = Deviation(x[:n_lengths], x[n_lengths:-2])
        points = marker_positions(arm, scene.plan.q_cmd, deviation)[:, columns]
        base = np.array([*x[-2:], bench.base_in_board_mm[2]])
        return project(bench.true_camera, robot_to_board(points, base).reshape(-1, 3)).reshape(target.shape)

    def misfit(x: Array) -> Array:
        return (predict(x) - target)[known]

    # Gross errors must not drag the geometry along, so the fit is robust beyond the noise.
    fit = least_squares(misfit, start, x_scale="jac", loss="soft_l1", f_scale=_ROBUST_PX, ftol=1e-5, max_nfev=12)
    predicted = predict(fit.x)
    return {name: predicted[:, k] for k, name in enumerate(names)}
