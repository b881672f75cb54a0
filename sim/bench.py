"""The simulated bench: MuJoCo moves the arm, the renderer and the sensor take its picture.

bench = SimulatedBench(world, seed=7)
bench.connect()
bench.move(q_cmd_rad)
frame = bench.capture()                                  # armtwin.models.bench.Frame
view = bench.capture_board(T_board_body)                 # the chessboard held before the same camera
block = bench.capture_gauge(30.0, bench.gauge_placement(x_mm, y_mm, angle_rad))
bench.close()
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from armtwin.models.bench import BenchDescription, Frame
from armtwin.models.camera import Camera, project
from armtwin.models.coordinate_frames import robot_to_board
from armtwin.models.errors import InputError, JobError
from armtwin.models.joint_limits import JointLimits
from armtwin.models.motion_arm import planar_arm
from armtwin.models.motion_world import MotionWorld, ideal_motion_world
from armtwin.models.world import Moment, World
from armtwin.sim.arm_view import arm_scene, backdrop, bodies_in_robot, bodies_on_board
from armtwin.sim.motion.film import Film, FilmedArm, filmed
from armtwin.sim.physics.simulation import ArmSimulation
from armtwin.sim.render import LensRenderer, Part, chessboard_parts, facing_camera, gauge_parts, panel_parts
from armtwin.sim.sensor import Sensor, expose

Array = NDArray[np.float64]

# Joints of a simulated arm whose drawing states no limits turn as far as a hobby servo does, either way.
_TURN_RAD = float(np.radians(90.0))


class SimulatedBench:
    """A world's arm and webcam, as `armtwin.models.bench.Bench`; the same seed gives the same pictures.

    Args:
        world: what is true; its faults of detection have no part in a picture.
        seed: of the sensor's noise.
        sensor: how light becomes a picture.
        shadows: whether the lamp throws shadows on the panel.
        n_poses: length of the recording, which a creeping camera needs to know; None where nothing creeps.
        obstacles: what else stands before the camera, fixed in the board frame.
        moving: the same arm as it moves in a film; by default one without faults.
        actuation: what tells this bench from others, see `armtwin.models.bench.BenchDescription`.

    """

    def __init__(
        self,
        world: World,
        *,
        seed: int | np.random.Generator = 0,
        sensor: Sensor | None = None,
        shadows: bool = True,
        n_poses: int | None = None,
        obstacles: Sequence[Part] = (),
        actuation: Mapping[str, Any] | None = None,
        moving: MotionWorld | None = None,
    ) -> None:
        if world.picture_lag < 0:
            raise InputError("command_shift: a bench cannot file pictures that it has not taken yet; rows must be >= 0")
        self.world = world
        self._sensor = sensor or Sensor()
        self._shadows = shadows
        self._n_poses = n_poses
        self._obstacles = tuple(obstacles)
        self._actuation = dict(actuation or {})
        self._moving = moving or ideal_motion_world(planar_arm(world.arm, world.deviation))
        self._rng = np.random.default_rng(seed)
        self._arm: ArmSimulation | None = None
        self._renderer: LensRenderer | None = None
        self._scene: Hashable = None
        self._moves = 0
        self._commanded_s: float | None = None
        self._time_s = 0.0
        self._payload_kg = 0.0
        self._buffer: deque[tuple[dict[str, Array], Array]] = deque(maxlen=world.picture_lag + 1)

    @property
    def description(self) -> BenchDescription:
        """What is declared of the world; nothing that is true of it alone."""
        return BenchDescription(
            kind="simulated",
            arm=self.world.arm,
            camera=self.world.camera,
            arm_plane_z_mm=self.world.arm_plane_z_mm,
            limits=JointLimits.of_arm(self.world.arm, _TURN_RAD),
            hangs_loads=True,
            actuation=self._actuation,
        )

    @property
    def notes(self) -> tuple[str, ...]:
        """Nothing: the simulated camera is as it was asked to be."""
        return ()

    @property
    def detached(self) -> bool:
        """Whether the bench is closed."""
        return self._arm is None

    @property
    def clock_origin_s(self) -> None:
        """None: its time is the simulation's."""

    def connect(self) -> None:
        """Set the arm up in its home pose; raises `JobError` where this machine has no off-screen OpenGL."""
        arm = self._arm = ArmSimulation(self.world)
        self._moves, self._time_s, self._commanded_s = 0, 0.0, None
        self._buffer.clear()
        self._show("arm", lambda: [*arm_scene(arm), *self._obstacles])

    def move(self, q_cmd_rad: Array) -> None:
        """Command (n,) joint angles, rad, as the next pose; returns when the arm is to be photographed."""
        arm = self._connected()
        period_s = self.world.pose_period_s
        given_s, seen_s = self._moves * period_s, (self._moves + 1) * period_s
        arm.move(np.asarray(q_cmd_rad, dtype=float), self._moves, given_s, self._payload_kg, seen_s)
        self._moves += 1
        self._commanded_s, self._time_s = given_s, seen_s
        self._buffer.append((bodies_in_robot(arm), arm.markers_mm()))

    def hang(self, payload_kg: float) -> None:
        """Hang a known mass at the tip before the next move; 0 takes it off."""
        self._payload_kg = payload_kg

    def capture(self) -> Frame:
        """Take a picture of the arm as it stands (or stood, where the camera hands out stale pictures)."""
        arm = self._connected()
        bodies = self._buffer[0][0] if self._buffer else bodies_in_robot(arm)
        renderer = self._show("arm", lambda: [*arm_scene(arm), *self._obstacles])
        return self._expose(renderer, bodies_on_board(self.world, bodies))

    def film(self, time_s: Array, q_cmd: Array) -> Iterator[Frame]:
        """Yield a picture of the moving arm at each of (N,) times, at which (N, n) commands, rad, are given."""
        self._connected()
        if self._renderer is not None:
            self._renderer.close()
            self._renderer, self._scene = None, None
        arm = FilmedArm(self.world, self._moving, time_s, q_cmd)
        film = Film(arm, self._sensor, self._rng, shadows=self._shadows, obstacles=self._obstacles)
        return filmed(film, time_s)

    def capture_board(self, T_body_board: Array) -> Frame:
        """Take a picture of the chessboard held at (4, 4) `T_body_board`, which maps its frame to the board frame."""
        renderer = self._show("board", lambda: [*panel_parts(), *chessboard_parts()])
        return self._expose(renderer, {"board": T_body_board})

    def capture_gauge(self, length_mm: float, T_body_board: Array) -> Frame:
        """Take a picture of a length gauge at (4, 4) `T_body_board` (see `gauge_placement`)."""
        renderer = self._show(("gauge", length_mm), lambda: [*backdrop(self.world), *gauge_parts(length_mm)])
        return self._expose(renderer, {"gauge": T_body_board})

    def gauge_placement(self, x_mm: float, y_mm: float, angle_rad: float) -> Array:
        """(4, 4) placement of a gauge's middle at board x, y in the arm's true plane, turned about the view."""
        turn = np.eye(4)
        turn[:2, :2] = [[np.cos(angle_rad), -np.sin(angle_rad)], [np.sin(angle_rad), np.cos(angle_rad)]]
        return facing_camera(x_mm, y_mm, float(self.world.base_in_board_mm[2])) @ turn

    def true_pixels(self) -> dict[str, Array]:
        """Where the markers' centres truly are in the next picture, (2,) px by name: for tests and figures."""
        arm = self._connected()
        points = self._buffer[0][1] if self._buffer else arm.markers_mm()
        pixels = project(self._camera(), robot_to_board(points, self.world.base_in_board_mm))
        return dict(zip(arm.marker_names, pixels, strict=True))

    def body_poses(self) -> dict[str, Array]:
        """(4, 4) true placement of each body in the robot frame, mm, as the next picture shows it."""
        return self._buffer[0][0] if self._buffer else bodies_in_robot(self._connected())

    def close(self) -> None:
        """Free the renderer; safe to call twice."""
        if self._renderer is not None:
            self._renderer.close()
        self._renderer, self._scene, self._arm = None, None, None

    def _connected(self) -> ArmSimulation:
        if self._arm is None:
            raise JobError("the simulated bench is not connected; call connect() first")
        return self._arm

    def _camera(self) -> Camera:
        sample = max(self._moves - 1, 0)
        last = max((self._n_poses or 1) - 1, 1)
        return self.world.camera_at(Moment(sample, self._time_s, min(sample / last, 1.0)))

    def _expose(self, renderer: LensRenderer, poses: dict[str, Array]) -> Frame:
        camera = self._camera()
        image = expose(renderer.render_linear(poses, camera), self._sensor, self._rng)
        return Frame(image, self._time_s, self._commanded_s)

    def _show(self, scene: Hashable, parts: Callable[[], list[Part]]) -> LensRenderer:
        """Return the renderer of a scene; one is kept at a time, since each holds its buffers."""
        if self._renderer is None or self._scene != scene:
            if self._renderer is not None:
                self._renderer.close()
            self._renderer = LensRenderer(self._camera(), parts(), shadows=self._shadows)
            self._scene = scene
        return self._renderer

    def __enter__(self) -> Self:
        self.connect()
        return self

    def __exit__(self, *error: object) -> None:
        self.close()
