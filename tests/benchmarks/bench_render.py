"""Time of a 1280x720 frame through the lens against MuJoCo's own renderer, memory, and two processes against one.

    python -m tests.benchmarks.bench_render [--frames 40]

Both renderers draw the same parts at the same poses; every frame has another pose, and the ways take turns, so that
whatever else the machine does falls on all alike; ratios are of medians. MuJoCo draws without a lens, with the four
samples a pixel that are its off-screen default. For whole pictures the camera is bumped at every frame; while it stands
still only the box around the arm is drawn. Processor time counts all threads and is steadier on a busy machine.
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import statistics
import time
from collections.abc import Callable, Mapping
from concurrent.futures import ProcessPoolExecutor
from contextlib import ExitStack
from multiprocessing.synchronize import Barrier
from pathlib import Path

os.environ.setdefault("MUJOCO_GL", "egl")

import mujoco
import numpy as np
from numpy.typing import NDArray

from armtwin.models.camera import Camera, back_project
from armtwin.models.lenses import PlumbBob
from armtwin.sim.render import LensRenderer, Part, arm_parts, panel_parts, planar_arm_poses, robot_bodies_on_board

Array = NDArray[np.float64]

LENGTHS_MM = [120.0, 121.7, 38.0, 6.73]
WIDTH, HEIGHT = 1280, 720
# Table 2 of the paper; transposed for column vectors and made orthonormal again.
K = np.array([[1438.6338, 0.0, 654.1560], [0.0, 1439.1291, 369.6557], [0.0, 0.0, 1.0]])
D = np.array([0.1630, 0.0428, 0.0064, 0.0016, -2.1819])
PRINTED_ROTATION = np.array([[-0.9988, 0.0041, 0.0497], [-0.0047, -0.9999, -0.0127], [0.0496, -0.0129, 0.9987]])


def webcam() -> Camera:
    """The paper's camera."""
    u, _, vt = np.linalg.svd(PRINTED_ROTATION)
    return Camera(WIDTH, HEIGHT, K, PlumbBob(D), u @ vt, np.array([118.6608, 41.34, 565.437]))


def scene(camera: Camera) -> tuple[list[Part], Array]:
    """The arm before its panel, in the middle of the picture, and where the robot's origin lies in the board frame."""
    centre = back_project(camera, np.array([[0.5 * WIDTH, 0.5 * HEIGHT]]), -80.87)[0]
    return [*panel_parts(), *arm_parts(LENGTHS_MM)], centre + np.array([-65.0, -60.0, 0.0])


def poses(base_mm: Array, frame: int) -> dict[str, Array]:
    """The arm on its way along a circle of joint angles."""
    q = 0.15 * np.array([np.sin(0.3 * frame), np.cos(0.3 * frame), np.sin(0.5 * frame)])
    return robot_bodies_on_board(planar_arm_poses(LENGTHS_MM, q), base_mm)


class MujocoScene:
    """The same parts on mocap bodies, seen by a camera with the same K and pose but no lens.

    Each part is a box of its size, which MuJoCo draws with 12 triangles: it is given less to do, not more.
    """

    def __init__(self, camera: Camera, parts: list[Part], *, shadows: bool) -> None:
        spec = mujoco.MjSpec()
        spec.visual.global_.offwidth, spec.visual.global_.offheight = WIDTH, HEIGHT
        spec.visual.map.znear, spec.visual.map.zfar = 0.06, 4.0
        spec.stat.extent = 1.0
        bodies = {
            name: spec.worldbody.add_body(name=name, mocap=True) for name in sorted({p.body for p in parts if p.body})
        }
        for part in parts:
            low, high = part.mesh.vertices.min(axis=0), part.mesh.vertices.max(axis=0)
            half = np.maximum(0.5 * (high - low), 0.1)
            (bodies[part.body] if part.body else spec.worldbody).add_geom(
                type=mujoco.mjtGeom.mjGEOM_BOX,
                pos=1e-3 * 0.5 * (low + high) + np.array([0.0, 0.0, 1e-3 * half[2] if part.body is None else 0.0]),
                size=1e-3 * half,
                rgba=[*(part.ink.colour if part.ink else part.colour), 1.0],
            )
        light = spec.worldbody.add_light(pos=[0.45, 0.75, -1.0], dir=[-0.45, -0.75, 1.0], castshadow=shadows)
        light.type = mujoco.mjtLightType.mjLIGHT_DIRECTIONAL
        R = camera.R_board_camera.T @ np.diag([1.0, -1.0, -1.0])  # OpenGL's camera looks along -z, y up
        quat = np.empty(4)
        mujoco.mju_mat2Quat(quat, R.ravel())
        spec.worldbody.add_camera(
            name="webcam",
            pos=-1e-3 * camera.R_board_camera.T @ camera.t_board_camera_mm,
            quat=quat,
            fovy=float(np.degrees(2.0 * np.arctan(0.5 * HEIGHT / camera.K[1, 1]))),
        )
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        self.mocap = {name: int(self.model.body(name).mocapid[0]) for name in bodies}
        self.renderer = mujoco.Renderer(self.model, HEIGHT, WIDTH)
        self.shadows = shadows

    def render(self, T_body_board: Mapping[str, Array]) -> NDArray[np.uint8]:
        for name, mocap in self.mocap.items():
            T = T_body_board[name]
            self.data.mocap_pos[mocap] = 1e-3 * T[:3, 3]
            mujoco.mju_mat2Quat(self.data.mocap_quat[mocap], np.ascontiguousarray(T[:3, :3]).ravel())
        mujoco.mj_kinematics(self.model, self.data)
        self.renderer.update_scene(self.data, "webcam")
        self.renderer.scene.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = self.shadows
        self.renderer.scene.flags[mujoco.mjtRndFlag.mjRND_REFLECTION] = False
        return self.renderer.render()


def time_frames(frames: int) -> dict[str, tuple[float, float]]:
    """Median wall and processor seconds of a frame, by the way it is drawn."""
    camera = webcam()
    parts, base_mm = scene(camera)
    with ExitStack() as stack:
        plain, bumped = (stack.enter_context(LensRenderer(camera, parts)) for _ in range(2))
        shaded, bumped_shaded = (stack.enter_context(LensRenderer(camera, parts, shadows=True)) for _ in range(2))
        mujoco_plain, mujoco_shaded = (MujocoScene(camera, parts, shadows=s) for s in (False, True))
        bump = iter(np.linspace(0.0, 1.0, 2 * frames + 20))

        def elsewhere() -> Camera:
            return camera.moved(np.eye(3), np.array([next(bump), 0.0, 0.0]))

        ways: dict[str, Callable[[dict[str, Array]], object]] = {
            "MuJoCo, no lens": mujoco_plain.render,
            "MuJoCo, no lens, shadows": mujoco_shaded.render,
            "lens, whole picture": lambda p: bumped.render(p, elsewhere()),
            "lens, whole picture, shadows": lambda p: bumped_shaded.render(p, elsewhere()),
            "lens, camera at rest": plain.render,
            "lens, camera at rest, shadows": shaded.render,
        }
        taken: dict[str, list[tuple[float, float]]] = {name: [] for name in ways}
        for frame in range(-3, frames):  # the first ones compile shaders and draw the kept background
            at = poses(base_mm, frame)
            for name, draw in ways.items():
                wall, cpu = time.perf_counter(), time.process_time()
                draw(at)
                if frame >= 0:
                    taken[name].append((time.perf_counter() - wall, time.process_time() - cpu))
    return {name: tuple(statistics.median(column) for column in zip(*t, strict=True)) for name, t in taken.items()}  # type: ignore[misc]


_together: list[Barrier] = []


def start_together(barrier: Barrier) -> None:
    """Give a worker the barrier at which it waits until all are ready."""
    _together.append(barrier)


def draw_for(seconds: float) -> tuple[float, float]:
    """Draw whole pictures with shadows: frames a second, and this process' peak memory, MB."""
    camera = webcam()
    parts, base_mm = scene(camera)
    with LensRenderer(camera, parts, shadows=True) as renderer:

        def draw(frame: int) -> None:
            renderer.render(poses(base_mm, frame), camera.moved(np.eye(3), np.array([1e-3 * frame, 0.0, 0.0])))

        draw(0)
        _together[0].wait(timeout=120.0)
        count, start = 0, time.perf_counter()
        while time.perf_counter() < start + seconds:
            count += 1
            draw(count)
        return count / (time.perf_counter() - start), peak_memory_mb()


def peak_memory_mb() -> float:
    """Highest resident memory of this process since it was started (getrusage would count its parent's at the fork)."""
    lines = Path("/proc/self/status").read_text("utf-8").splitlines()
    return next(float(line.split()[1]) / 1024.0 for line in lines if line.startswith("VmHWM"))


def rate(processes: int, seconds: float) -> tuple[float, float]:
    """Frames a second of some processes together, and the greatest peak memory of one, MB."""
    spawn = multiprocessing.get_context("spawn")
    barrier = spawn.Barrier(processes)
    with ProcessPoolExecutor(processes, mp_context=spawn, initializer=start_together, initargs=(barrier,)) as pool:
        done = list(pool.map(draw_for, [seconds] * processes))
    return sum(frames for frames, _ in done), max(memory for _, memory in done)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--frames", type=int, default=40, help="frames timed of each way")
    parser.add_argument("--seconds", type=float, default=4.0, help="time that one and two processes draw for")
    arguments = parser.parse_args()

    timed = time_frames(arguments.frames)
    wall_1, cpu_1 = timed["MuJoCo, no lens"]
    limits = {"lens, whole picture": 1.25, "lens, whole picture, shadows": 1.75}
    print(f"{'1280 x 720, one frame':32s} {'wall ms':>8s} {'ratio':>6s} {'cpu ms':>8s} {'ratio':>6s}  limit")
    for name, (wall, cpu) in timed.items():
        limit = f"{limits[name]:5.2f}" if name in limits else ""
        print(f"{name:32s} {1e3 * wall:8.1f} {wall / wall_1:6.2f} {1e3 * cpu:8.1f} {cpu / cpu_1:6.2f}  {limit}")

    one, memory = rate(1, arguments.seconds)
    two, _ = rate(2, arguments.seconds)
    print(f"\none process   {one:6.1f} frames/s")
    print(f"two processes {two:6.1f} frames/s, {two / one:.2f} times one  (limit 1.30)")
    print(f"peak memory   {memory:6.0f} MB  (limit 350)")


if __name__ == "__main__":
    main()
