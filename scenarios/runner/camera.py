"""Stages of the camera: the chessboard is held before it, and it is calibrated (section 5.1)."""

from __future__ import annotations

from contextlib import closing
from typing import Any

import numpy as np

from armtwin.calib.camera import Board, Corners, calibrate_camera, find_corners
from armtwin.models.atomic import folder_aside
from armtwin.models.camera import Camera
from armtwin.models.camera_files import nominal_camera, write_camera
from armtwin.models.recordings.reader import camera_from_table
from armtwin.models.recordings.writer import camera_table
from armtwin.models.validation import CameraTable, check
from armtwin.scenarios.benches.simulated import simulated_bench
from armtwin.scenarios.runner.board_views import board_poses
from armtwin.scenarios.runner.frames import read_frame, write_frame
from armtwin.scenarios.runner.job import Job
from armtwin.scenarios.runner.picture import generator
from armtwin.scenarios.runner.stage import Tick
from armtwin.scenarios.runner.world import true_camera

# 10 columns x 7 rows of 23 mm squares (section 5.1): 9 x 6 inner corners.
BOARD = Board(columns=9, rows=6, square_mm=23.0)


def take_board_views(job: Job, tick: Tick) -> dict[str, Any]:
    """Render the chessboard in every view, through the true camera."""
    scenario = job.scenario
    camera = true_camera(scenario)
    side = BOARD.square_mm
    outer = np.array([[-side, -side, 0], [9 * side, -side, 0], [9 * side, 6 * side, 0], [-side, 6 * side, 0]])
    poses = board_poses(camera, outer, scenario.board_views, generator(scenario, "board poses"))
    with folder_aside(job.out / "board") as folder, closing(simulated_bench(scenario, "board")) as bench:
        for view, pose in enumerate(poses):
            write_frame(folder, view, bench.capture_board(pose).image)
            tick(view + 1, len(poses))
    return {"poses": poses}


def calibrate(job: Job, tick: Tick) -> dict[str, Any]:
    """Find the corners and calibrate; the first view, the board in its mount, gives the camera's pose."""
    names = [f"{view:06d}.png" for view in range(job.scenario.board_views)]
    views = []
    for view, name in enumerate(names):
        pixels = find_corners(read_frame(job.out / "board", view), BOARD)
        if pixels is not None:
            views.append(Corners(name, pixels))
        tick(view + 1, len(names))
    nominal = nominal_camera()
    fit = calibrate_camera(views, BOARD, (nominal.image_width, nominal.image_height))
    write_camera(job.out / "camera.yaml", fit.camera, name="calibrated")
    return {
        "camera": camera_table(fit.camera),
        "intrinsics": fit.intrinsics,
        "std": fit.std,
        "jackknife_std": fit.jackknife_std,
        "pose_std": fit.uncertainty.pose_std[fit.reference],
        "rms_px": fit.rms_px,
        "per_view_rms_px": fit.per_view_rms_px,
        "corners_px": [view.pixels for view in views],
        "views": [view.name for view in views],
    }


def calibrated_camera(job: Job) -> Camera:
    """Return the camera that the camera stage found."""
    return camera_from_table(check(CameraTable, job.load("camera")["camera"], "stages/camera.json"))
