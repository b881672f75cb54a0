"""How long an arm calibration on 100 poses takes: `python tests/benchmarks/bench_calibration.py`.

Two circles of 50 poses, four markers, 0.06 px of noise. Target: least squares within 5 ms. Algorithm 1 is timed by
the step: how many it takes is its stopping rule's affair.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # matrices of nine columns gain nothing by threads

import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import numpy as np

from armtwin.calib.arm import algorithm_1, least_squares
from armtwin.models.arm import nominal_arm
from armtwin.models.camera import project
from armtwin.models.camera_files import read_camera
from armtwin.models.coordinate_frames import robot_to_board
from armtwin.models.kinematics import Deviation, inverse, marker_positions
from armtwin.models.recordings.recording import Recording
from armtwin.models.trajectories import paper_trajectories

TARGET_MS = 5.0
REPEATS = 200
ARM_PLANE_Z_MM = -80.87
NOMINAL_CAMERA = Path(__file__).resolve().parents[2] / "models" / "nominal" / "webcam.yaml"


def recording() -> Recording:
    """100 poses of an arm that deviates as Table 4 says."""
    arm, camera = nominal_arm(), read_camera(NOMINAL_CAMERA)
    delta = Deviation(np.array([6.7015, 4.5704, -0.7074, 1.0208]), np.radians([1.1354, 1.0037, 4.7563]))
    poses = paper_trajectories()
    q = inverse(arm, np.concatenate([poses["circle_15"], poses["circle_25"]]))
    base = np.array([-35.0, -20.0, ARM_PLANE_Z_MM])
    points = marker_positions(arm, q, delta)
    rng = np.random.default_rng(0)
    pixels = {
        name: project(camera, robot_to_board(points[:, i], base)) + rng.normal(0, 0.06, (len(q), 2))
        for i, name in enumerate(arm.marker_names)
    }
    return Recording(
        arm=arm,
        camera=camera,
        arm_plane_z_mm=ARM_PLANE_Z_MM,
        sample=np.arange(len(q)),
        time_s=np.full(len(q), np.nan),
        trajectory=np.repeat(["circle_15", "circle_25"], 50),
        q_cmd=q,
        markers_px=pixels,
    )


def main() -> None:
    """Print the median and the best time of least squares, and the time of a step of Algorithm 1."""
    data = recording()
    least_squares.calibrate(data)
    wall, cpu = [], []
    for _ in range(REPEATS):
        begin, begin_cpu = time.perf_counter(), time.process_time()
        least_squares.calibrate(data)
        wall.append(1e3 * (time.perf_counter() - begin))
        cpu.append(1e3 * (time.process_time() - begin_cpu))
    for clock, times in (("wall", wall), ("processor", cpu)):
        print(f"least squares, 100 poses, {clock} time: median {np.median(times):.2f} ms, best {min(times):.2f} ms")
    print(f"target {TARGET_MS} ms")
    begin = time.perf_counter()
    algorithm_1.calibrate(data, error_max_mm=0.0)
    whole = 1e3 * (time.perf_counter() - begin)
    steps = algorithm_1.MAX_STEPS
    print(f"Algorithm 1, 100 poses: {whole:.0f} ms for {steps} steps, {1e3 * whole / steps:.0f} us a step")


if __name__ == "__main__":
    main()
