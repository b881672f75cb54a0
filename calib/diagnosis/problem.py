"""A recording as a regression: observed channels, what the twin predicts for them, and its derivative by the geometry.

Channels are (N, M, d): pixels of M markers (d = 2), or the angles of M joints (d = 1). A chain is linear in its base
and in its complex links, so the geometry is fitted in those: base x, base y, then real and imaginary part of each link.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.diagnosis.grain import floor_of, reading_grains
from armtwin.models.camera import back_project
from armtwin.models.catalogue.context import Context, nominal_links
from armtwin.models.catalogue.points import Geometry
from armtwin.models.catalogue.predict import Active, camera_path, joint_angles, marker_points
from armtwin.models.coordinate_frames import R_ROBOT_BOARD, board_to_robot, robot_to_board
from armtwin.models.kinematics import along_path, by_joint
from armtwin.models.recordings.recording import Recording

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Bool = NDArray[np.bool_]

# Priors of the geometry, wide enough never to bind where the poses tell anything: a printed link is not off by 30 mm.
_PRIOR_LINK_MM = 30.0
_PRIOR_BASE_MM = 300.0
# The zero pose of an arm other than the paper's is not stated in its recording, so its links may point anywhere.
_PRIOR_UNSTATED_ZERO_MM = 3000.0


@dataclass(frozen=True, eq=False)
class Problem:
    """The fixed side of a diagnosis.

    Attributes:
        context: commands, times, arm and camera as assumed.
        observed: (N, M, d) channels, NaN where nothing was seen.
        base_in_board_mm: (3,) robot origin about which the base is fitted, from the drawing and the data.
        nominal: (g,) geometry of the drawing.
        channels: names of the M channels for people.
        grain_std: least standard deviation that the steps of the readings leave, in the channels' unit; 0 without any.

    """

    context: Context
    observed: Array
    base_in_board_mm: Array
    nominal: Array
    channels: tuple[str, ...]
    grain_std: float = 0.0

    @property
    def is_pixels(self) -> bool:
        """Whether pixels were measured, not angles."""
        return self.observed.shape[-1] == 2

    @cached_property
    def prior_std(self) -> Array:
        """(g,) standard deviations of the geometry's prior about the drawing."""
        if not self.is_pixels:
            return np.full(len(self.nominal), np.pi)
        link = _PRIOR_LINK_MM if self.context.arm.form.zero_is_drawn else _PRIOR_UNSTATED_ZERO_MM
        return np.concatenate([np.full(2, _PRIOR_BASE_MM), np.full(len(self.nominal) - 2, link)])

    def geometry(self, g: Array) -> Geometry:
        """Return the chain that the parameters (g,) stand for."""
        z = g[2::2] + 1j * g[3::2]
        n = self.context.arm.n_joints
        return Geometry(g[:2], z[:n], complex(z[n]) if len(z) > n else 0j)

    def at(self, rows: NDArray[np.int64]) -> Problem:
        """Return the problem of some rows (K,) alone."""
        return replace(self, context=self.context.at(rows), observed=self.observed[rows])

    def with_links(self, g: Array) -> Problem:
        """Return the problem whose terms know the calibrated links (for torques and pivots)."""
        if not self.is_pixels:
            return self
        return replace(self, context=replace(self.context, links=self.geometry(g).links))

    def predict(self, g: Array, effects: Sequence[Active], q: Array | None = None) -> Array:
        """(N, M, d) predicted channels; `q` (N, n) are the link angles where they are known already."""
        if q is None:
            q = joint_angles(self.context, effects)
        if not self.is_pixels:
            return (q + g)[..., None]
        points = marker_points(self.context, self.geometry(g), q, effects)
        assert self.context.camera is not None
        board = robot_to_board(points, self.base_in_board_mm)
        return camera_path(self.context, effects).project(self.context.camera, board)

    def predict_with_jacobian(self, g: Array, effects: Sequence[Active]) -> tuple[Array, Array]:
        """(N, M, d) predicted channels and their (N, M, d, g) derivative by the geometry.

        The derivative leaves out what a term does with the geometry (pivots, torques): that is of second order.
        """
        q = joint_angles(self.context, effects)
        if not self.is_pixels:
            J = np.broadcast_to(np.eye(q.shape[1])[:, None, :], (*q.shape, 1, q.shape[1]))
            return (q + g)[..., None], J
        camera = self.context.camera
        assert camera is not None
        points = marker_points(self.context, self.geometry(g), q, effects)
        board = robot_to_board(points, self.base_in_board_mm)
        pixels = camera_path(self.context, effects).project(camera, board)
        by_x, by_y = self._slopes(board, effects)
        J = np.zeros((*pixels.shape, len(g)))
        J[..., 0], J[..., 1] = by_x, by_y
        directions = self.context.directions(q)
        for column, name in enumerate(self.context.markers):
            along = along_path(self.context.arm, directions, name)[:, : len(g) // 2 - 1]
            J[:, column, :, 2::2] = _in_pixels(along, by_x[:, column], by_y[:, column])
            J[:, column, :, 3::2] = _in_pixels(1j * along, by_x[:, column], by_y[:, column])
        return pixels, J

    def jacobian_by_joint(self, g: Array, q: Array, effects: Sequence[Active] = ()) -> Array:
        """(N, M, d, n) derivative of the channels by the link angles (N, n), seen as the camera's `effects` have it."""
        if not self.is_pixels:
            return np.broadcast_to(np.eye(q.shape[1])[:, None, :], (*q.shape, 1, q.shape[1]))
        points = marker_points(self.context, self.geometry(g), q)
        by_x, by_y = self._slopes(robot_to_board(points, self.base_in_board_mm), effects)
        directions, c = self.context.directions(q), g[2::2] + 1j * g[3::2]
        J = np.zeros((*by_x.shape, q.shape[1]))
        for column, name in enumerate(self.context.markers):
            along = along_path(self.context.arm, directions, name)[:, : len(c)]
            J[:, column] = _in_pixels(by_joint(self.context.arm, along, c), by_x[:, column], by_y[:, column])
        return J

    def pixels_by_plane(self, g: Array) -> tuple[Array, Array]:
        """Two (N, M, 2) derivatives of the pixels by the robot's x and y, pixels per mm, at the commanded poses."""
        points = marker_points(self.context, self.geometry(g), self.context.q_cmd)
        return self._slopes(robot_to_board(points, self.base_in_board_mm), ())

    def _slopes(self, board: Array, effects: Sequence[Active]) -> tuple[Array, Array]:
        """Two (N, M, 2) derivatives of the pixels by the robot's x and y at board points."""
        camera = self.context.camera
        assert camera is not None
        by_x, by_y = camera_path(self.context, effects).slopes(camera, board, R_ROBOT_BOARD[:2])
        return by_x, by_y


def _in_pixels(moved: Complex, by_x: Array, by_y: Array) -> Array:
    """(N, 2, K) pixels for (N, K) motions in the robot's plane, by (N, 2) slopes of the pixels by its x and y."""
    return by_x[:, :, None] * moved.real[:, None, :] + by_y[:, :, None] * moved.imag[:, None, :]


def problem_of(recording: Recording) -> Problem:
    """Return the regression that a recording states."""
    markers = tuple(name for name, pixels in recording.markers_px.items() if np.isfinite(pixels).any())
    arm, time = recording.arm, recording.time_s
    context = Context(
        arm=arm,
        camera=recording.camera if markers else None,
        plane_z_mm=recording.arm_plane_z_mm or 0.0,
        markers=markers,
        q_cmd=recording.q_cmd,
        time_s=time if recording.has_time else None,
        commanded_s=recording.commanded_s,
        trajectory=recording.trajectory,
        payload_kg=np.zeros(len(recording)) if recording.payload_kg is None else np.nan_to_num(recording.payload_kg),
        temperature_c=recording.temperature_c,
        links=nominal_links(arm),
    )
    grain_std = floor_of(reading_grains(recording))
    if not markers:
        assert recording.q_meas is not None
        names = tuple(f"joint {joint + 1}" for joint in range(arm.n_joints))
        return Problem(context, recording.q_meas[..., None], np.zeros(3), np.zeros(arm.n_joints), names, grain_std)
    observed = np.stack([recording.markers_px[name] for name in markers], axis=1)
    links = nominal_links(arm)
    corner = [complex(arm.link_lengths_mm[-2])] if arm.form.corner in markers else []
    z = np.concatenate([links, corner])
    nominal = np.concatenate([np.zeros(2), np.stack([z.real, z.imag], axis=-1).ravel()])
    base = _first_base(context, observed)
    return Problem(context, observed, base, nominal, markers, grain_std)


def _first_base(context: Context, observed: Array) -> Array:
    """(3,) where the drawing's arm must stand in the board frame to meet what was seen, by medians."""
    assert context.camera is not None
    z = context.plane_z_mm
    geometry = Geometry(np.zeros(2), context.links, complex(abs(context.links[-1])))
    drawn = marker_points(context, geometry, context.q_cmd)
    seen = back_project(context.camera, observed, z)
    shift = board_to_robot(seen, np.zeros(3))[..., :2] - drawn[..., :2]
    first = shift[:, :1] if context.markers[0] == "a" and np.isfinite(shift[:, 0]).any() else shift
    robot = np.nanmedian(first.reshape(-1, 2), axis=0)
    return np.array([-robot[0], robot[1], z])
