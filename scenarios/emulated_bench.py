"""The emulated bench: a bench file whose serial port and camera lead to an emulated Arduino and a filmed simulation.

with EmulatedBench() as emulated:
    setup = read_bench(emulated.bench_file)      # from here on nothing knows that the bench is emulated
    bench = HardwareBench(setup)

It has the paper's arm, or any other that its camera sees all of: one servo on the Arduino for each of its joints.
"""

from __future__ import annotations

import multiprocessing
import os
import tempfile
from collections.abc import Callable
from functools import partial
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w
from numpy.typing import NDArray

from armtwin.hardware.bench.bench_file import BenchSetup, setup_of
from armtwin.hardware.bench.tables import BenchTable
from armtwin.models.arm import Arm, nominal_arm
from armtwin.models.atomic import clear_if_left, hold
from armtwin.models.camera import Camera, back_project
from armtwin.models.camera_files import nominal_camera, write_camera
from armtwin.models.errors import InputError, JobError
from armtwin.models.kinematics import Deviation, marker_positions
from armtwin.models.recordings.writer import arm_table
from armtwin.models.validation import check
from armtwin.models.world import World, ideal_world
from armtwin.scenarios.emulated_film import film
from armtwin.sim.sensor import Sensor

Array = NDArray[np.float64]

ARM_PLANE_Z_MM = -80.87  # section 3.2 of the paper
MIN_SPEED = 0.1
MAX_SPEED = 4.0  # beyond it the firmware's two seconds of silence pass faster than a busy host may answer
# What another arm is built off its drawing: about a millimetre in a link, two degrees in a joint.
_LENGTH_ERROR = 0.01
_JOINT_ERROR_RAD = 0.03
_ARM_FILE = "arm.toml"
_A_DAY_S = 86400.0
START_TIMEOUT_S = 120.0  # the firmware and the emulator are built on the first start


def paper_world() -> World:
    """Return the paper's bench as its second calibration found it (Table 4): what a capture has to discover."""
    deviation = Deviation(np.array([6.7015, 4.5704, -0.7074, 1.0208]), np.radians([1.1354, 1.0037, 4.7973]))
    return ideal_world(nominal_arm(), nominal_camera(), ARM_PLANE_Z_MM, deviation=deviation)


def world_of(arm: Arm) -> World:
    """Return a bench with another arm, built a little off its drawing, its rest pose in the middle of the picture."""
    turns = np.where(np.arange(arm.n_joints) % 2, -1.0, 1.0)
    signs = np.where(np.arange(len(arm.link_lengths_mm)) % 2, -1.0, 1.0)
    off = Deviation(_LENGTH_ERROR * signs * arm.link_lengths_mm, _JOINT_ERROR_RAD * turns)
    camera = nominal_camera()
    at_rest = marker_positions(arm, np.zeros((1, arm.n_joints)))[0].mean(axis=0)
    base = _middle_mm(camera) - at_rest * (-1.0, 1.0)  # x_board = -x_robot (equation 12)
    return ideal_world(arm, camera, ARM_PLANE_Z_MM, base, off)


def _middle_mm(camera: Camera) -> Array:
    """(2,) what the picture's middle shows of the arm's plane, board frame."""
    middle = np.array([[camera.image_width - 1.0, camera.image_height - 1.0]]) / 2.0
    return back_project(camera, middle, ARM_PLANE_Z_MM)[0, :2]


def bench_table(port: str, url: str, arm: Arm | None = None) -> dict[str, Any]:
    """Return the content of the emulated bench's file: an MG996R a joint, every second one turned round."""
    joint = {"zero_us": 1500.0, "us_per_rad": 636.62, "min_rad": -1.2, "max_rad": 1.2}
    n_joints = (nominal_arm() if arm is None else arm).n_joints
    return {
        "schema": "armtwin.bench/1",
        **({} if arm is None else {"arm": _ARM_FILE}),
        "serial": {"port": port},
        "camera": {"source": url, "calibration": "camera.yaml", "arm_plane_z_mm": ARM_PLANE_Z_MM},
        "joints": [{"servo": i + 1, "direction": -1 if i % 2 else 1, **joint} for i in range(n_joints)],
        "motion": {"max_step_rad": 0.5, "speed_rad_s": 1.5, "start_speed_rad_s": 0.5},
    }


def emulated_setup(port: str, url: str, arm: Arm | None = None) -> BenchSetup:
    """Return what the emulated bench's file says, without the file."""
    table = check(BenchTable, bench_table(port, url, arm), "emulated")
    return setup_of(table, nominal_arm() if arm is None else arm, nominal_camera())


class EmulatedBench:
    """Starts the emulated Arduino, the arm and the stream in a process of their own; use as a context manager.

    `arm` is another arm than the paper's; its `world_of` is filmed unless `make_world` makes one of the same arm, which
    is called in that process, so that it must be a function of a module. At `speed` 2 a second of the arm and
    the Arduino passes in half a second; the stream stays at 30 Hz, and what the host waits for (three or four still
    pictures, timeouts) stays in real time, so that a capture gains less than `speed`, and nothing on a machine that has
    not the time to emulate so fast: two cores make 2. Raises `InputError` for a speed that is not from 0.1 to 4.
    """

    def __init__(
        self,
        make_world: Callable[[], World] | None = None,
        *,
        arm: Arm | None = None,
        sensor: Sensor | None = None,
        shadows: bool = False,
        speed: float = 1.0,
    ) -> None:
        if not MIN_SPEED <= speed <= MAX_SPEED:  # false for NaN
            raise InputError(f"speed of the emulated bench: {speed:g} is not between {MIN_SPEED:g} and {MAX_SPEED:g}")
        self._arm = arm
        self._make_world = make_world or (paper_world if arm is None else partial(world_of, arm))
        self._sensor = Sensor() if sensor is None else sensor
        self._shadows = shadows
        self._speed = speed
        self._folder: tempfile.TemporaryDirectory[str] | None = None
        self._process: multiprocessing.process.BaseProcess | None = None
        self._pipe: Connection | None = None

    def start(self) -> None:
        """Start everything and write the bench file; raises `JobError` where the emulator cannot be built or run."""
        for old in Path(tempfile.gettempdir()).glob("armtwin-bench-*"):  # of programs that were killed
            clear_if_left(old, older_than_s=_A_DAY_S)
        self._folder = tempfile.TemporaryDirectory(prefix="armtwin-bench-")
        self._held = hold(Path(self._folder.name))
        write_camera(self.bench_file.parent / "camera.yaml", nominal_camera())
        if self._arm is not None:
            arm_file = {"schema": "armtwin.arm/1", **arm_table(self._arm)}
            self.bench_file.with_name(_ARM_FILE).write_text(tomli_w.dumps(arm_file), "utf-8")
        servo_map = emulated_setup("/dev/null", "http://127.0.0.1/", self._arm).servo_map
        context = multiprocessing.get_context("spawn")  # an OpenGL context does not live through a fork
        self._pipe, theirs = context.Pipe()
        self._process = context.Process(
            target=film,
            args=(theirs, self._make_world, servo_map, self._sensor, self._shadows, self._speed),
            name="emulated-bench",
            daemon=True,
        )
        self._process.start()
        theirs.close()
        match self._receive(START_TIMEOUT_S):
            case ("ready", str(port), str(url)):
                self._write(port, url)
            case ("failed", message):
                self.close()
                raise JobError(f"emulated bench: {message}")

    def close(self) -> None:
        """End everything. May be called twice."""
        if self._pipe is not None:
            self._pipe.close()
            self._pipe = None
        if self._process is not None:
            self._process.join(10.0)
            if self._process.is_alive():
                self._process.kill()
                self._process.join()
            self._process = None
        if self._folder is not None:
            self._folder.cleanup()
            os.close(self._held)
            self._folder = None

    def __enter__(self) -> EmulatedBench:
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def bench_file(self) -> Path:
        """The bench file; the camera file stands beside it."""
        if self._folder is None:
            raise JobError("the emulated bench is not running")
        return Path(self._folder.name) / "bench.toml"

    def tell(self, *words: object) -> tuple[Any, ...]:
        """Make something happen, as `emulated_film` lists it: ("unplug",), ("late", 1.0), ("hide", "b") ..."""
        if self._pipe is None:
            raise JobError("the emulated bench is not running")
        try:
            self._pipe.send(words)
        except BrokenPipeError:
            raise JobError("the emulated bench has ended") from None
        return self._receive(30.0)[1:]

    def hang(self, payload_kg: float) -> None:
        """Hang a mass at the tip."""
        self.tell("payload", float(payload_kg))

    def quicken(self) -> None:
        """Let the servos approach what they hear as fast as their data sheet says: for a film of the arm on its way."""
        self.tell("quicken")

    def hold(self) -> float:
        """Let emulated time stand until `step`, and return it, s."""
        return float(self.tell("hold")[0])

    def step(self, until_s: float, send: Callable[[], None]) -> tuple[float, bytes]:
        """Send a command to the board that stands, and let its world run until a time, s; return it and a JPEG then.

        The command arrives at the moment at which the world stood: how busy the machine is does not matter.
        """
        if self._pipe is None:
            raise JobError("the emulated bench is not running")
        self._pipe.send(("step", float(until_s)))
        send()
        _, seen_s, picture = self._receive(30.0)
        return seen_s, picture

    def release(self) -> None:
        """Let emulated time run on with real time."""
        self.tell("release")

    def widths_us(self) -> Array:
        """(6,) pulse widths on the servo pins now, us; NaN for a limp servo."""
        widths: Array = self.tell("widths")[0]
        return widths

    def _receive(self, timeout_s: float) -> tuple[Any, ...]:
        if self._pipe is None or not self._pipe.poll(timeout_s):
            raise JobError(f"the emulated bench did not answer in {timeout_s:g} s")
        try:
            answer: tuple[Any, ...] = self._pipe.recv()
        except (EOFError, ConnectionResetError):
            raise JobError("the emulated bench has ended") from None
        return answer

    def _write(self, port: str, url: str) -> None:
        self.bench_file.write_text(tomli_w.dumps(bench_table(port, url, self._arm)), "utf-8")
