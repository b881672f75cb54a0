"""What the camera and its detection make of the arm: markers in space to pixels in a recording."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from armtwin.models.camera import project
from armtwin.models.coordinate_frames import robot_to_board
from armtwin.models.recordings.recording import Recording, make_samples
from armtwin.models.world import Moment, World
from armtwin.sim.physics.simulation import default_clock, simulate, simulate_angles

Array = NDArray[np.float64]


def progress_of(time_s: Array, span_s: float | None = None) -> Array:
    """(N,) share of the recording that is over at each time; of its first `span_s` where it was gone on with."""
    elapsed = time_s - time_s[0]
    whole = float(elapsed[-1]) if span_s is None else span_s
    return elapsed / whole if whole > 0 else np.zeros_like(elapsed)


def pixels_of(world: World, markers_robot_mm: Array, time_s: Array, span_s: float | None = None) -> dict[str, Array]:
    """Project (N, M, 3) markers in the robot frame, mm, through the true camera: raw pixels (N, 2) by marker.

    A marker outside the picture is NaN: it was not seen. What goes on over a recording goes on over `span_s`, by
    default all of it.
    """
    n = len(markers_robot_mm)
    pixels = np.empty((*markers_robot_mm.shape[:2], 2))
    progress = progress_of(time_s, span_s)
    for row in range(n):
        camera = world.camera_at(Moment(row, float(time_s[row]), float(progress[row])))
        pixels[row] = project(camera, robot_to_board(markers_robot_mm[row], world.base_in_board_mm))
    width, height = world.true_camera.image_width, world.true_camera.image_height
    outside = ((pixels < -0.5) | (pixels > np.array([width, height]) - 0.5)).any(axis=-1)
    pixels[outside] = np.nan
    return {name: pixels[:, column] for column, name in enumerate(world.arm.known_markers)}


def make_recording(
    world: World,
    q_cmd: Array,
    trajectory: Sequence[str] | NDArray[np.str_],
    time_s: Array | None,
    rng: Generator,
    noise_px: float,
    *,
    truth_px: dict[str, Array] | None = None,
    held_out: tuple[str, ...] = (),
    markers: Sequence[str] | None = None,
    missing: float = 0.0,
    payload_kg: Array | None = None,
    declare_noise: bool = True,
) -> Recording:
    """Run (N, n) commands in a world and return what a bench would have recorded, with the declared arm and camera.

    `noise_px` is the standard deviation of one pixel coordinate, `missing` the share of sightings that are lost,
    `markers` those that are looked for (default: all on the axes and the tip). The arm is seen at `time_s` or, where
    that is None, once in each of the world's periods, and the recording then has no times. `truth_px` are the true
    pixels (`pixels_of`) where that has been done before.
    """
    n = len(q_cmd)
    if truth_px is None:
        clock = default_clock(n, world.pose_period_s) if time_s is None else time_s
        truth_px = pixels_of(world, simulate(world, q_cmd, clock, payload_kg), clock)
    seen = {}
    for name in world.arm.marker_names if markers is None else markers:
        seen[name] = truth_px[name] + noise_px * rng.standard_normal(truth_px[name].shape)
        seen[name][rng.random(n) < missing] = np.nan
    for detection in world.detections:
        seen = detection(seen, rng)
    return Recording(
        arm=world.arm,
        sample=make_samples(n),
        time_s=np.full(n, np.nan) if time_s is None else np.asarray(time_s, dtype=float),
        trajectory=np.asarray(trajectory, dtype=np.str_),
        q_cmd=np.asarray(q_cmd, dtype=float),
        markers_px=seen,
        payload_kg=payload_kg,
        camera=world.camera,
        arm_plane_z_mm=world.arm_plane_z_mm,
        pixel_noise_px=noise_px if declare_noise else None,
        held_out=held_out,
    )


def make_angle_recording(
    world: World,
    q_cmd: Array,
    trajectory: Sequence[str] | NDArray[np.str_],
    time_s: Array | None,
    rng: Generator,
    noise_rad: float,
    *,
    held_out: tuple[str, ...] = (),
    payload_kg: Array | None = None,
) -> Recording:
    """Run (N, n) commands and read every joint with a protractor of standard deviation `noise_rad`, without a camera.

    Times and payload as for `make_recording`.
    """
    n = len(q_cmd)
    clock = default_clock(n, world.pose_period_s) if time_s is None else time_s
    angles = simulate_angles(world, q_cmd, clock, payload_kg)
    return Recording(
        arm=world.arm,
        sample=make_samples(n),
        time_s=np.full(n, np.nan) if time_s is None else np.asarray(time_s, dtype=float),
        trajectory=np.asarray(trajectory, dtype=np.str_),
        q_cmd=np.asarray(q_cmd, dtype=float),
        q_meas=angles + noise_rad * rng.standard_normal(angles.shape),
        payload_kg=payload_kg,
        held_out=held_out,
    )
