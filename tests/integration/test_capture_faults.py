"""What goes wrong at a bench, done to the emulated one: the servos end detached, and the recording is whole or goes on.

The host is the real one: serial link, webcam, capture. Behind the port runs the real firmware, behind the stream the
simulated arm.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
import tomllib
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import tomli_w

from armtwin.calib.markers import measure_recording
from armtwin.hardware.bench.bench_file import BenchSetup, read_bench
from armtwin.hardware.bench.hardware_bench import HardwareBench
from armtwin.hardware.camera.webcam import CameraLostError
from armtwin.hardware.capture.capture import run_capture
from armtwin.hardware.capture.folder import CaptureFolder
from armtwin.hardware.emulator import missing_packages
from armtwin.hardware.link.servo_link import BoardResetError, LinkLostError
from armtwin.models.camera import project
from armtwin.models.coordinate_frames import robot_to_board
from armtwin.models.errors import JobError
from armtwin.models.kinematics import marker_positions
from armtwin.models.plan import Plan, write_plan
from armtwin.models.recordings.reader import read_recording
from armtwin.scenarios.emulated_bench import EmulatedBench, paper_world
from tests.support.disks import mounted

pytestmark = [
    pytest.mark.avr,
    pytest.mark.slow,
    pytest.mark.skipif(bool(missing_packages()), reason=missing_packages() or "present"),
]

# Out and back in wide steps, each of most of a second: time enough for something to happen in the middle of one.
Q = np.array([[0.1, 0.1, -0.1], [0.4, 0.3, -0.3], [0.1, 0.1, -0.1], [0.4, 0.3, -0.3], [0.1, 0.1, -0.1]])
PLAN = Plan(np.full(len(Q), "to_and_fro"), Q, np.zeros(len(Q)))
SILENCE_S = 2.0  # after which the firmware detaches
MIDDLE_OF_A_MOVE_S = 0.25


@pytest.fixture(scope="module")
def emulated() -> Iterator[EmulatedBench]:
    with EmulatedBench() as running:
        yield running


@pytest.fixture
def setup(emulated: EmulatedBench) -> BenchSetup:
    setup = read_bench(emulated.bench_file)
    return replace(setup, motion=setup.motion.model_copy(update={"speed_rad_s": 0.5}))


@pytest.fixture
def recording(setup: BenchSetup, tmp_path: Path) -> Iterator[CaptureFolder]:
    opened = open_recording(setup, tmp_path / "recording")
    yield opened
    opened.close()


def open_recording(setup: BenchSetup, folder: Path) -> CaptureFolder:
    recording = CaptureFolder(folder, setup.description, PLAN)
    recording.open()
    return recording


def capture(setup: BenchSetup, recording: CaptureFolder, after_two: Callable[[], object] | None = None) -> None:
    """Capture what is missing; `after_two` happens once two poses are on disk."""

    def report(done: int, total: int) -> None:
        if done == 2 and after_two is not None:
            after_two()

    with HardwareBench(setup) as bench:
        run_capture(bench, recording, report)


def soon(happen: Callable[[], object]) -> Callable[[], None]:
    """Return what makes it happen in the middle of the next move."""
    return threading.Timer(MIDDLE_OF_A_MOVE_S, happen).start


def detached(emulated: EmulatedBench, within_s: float) -> bool:
    """Whether all pins are without pulses at the latest after so long."""
    deadline = time.monotonic() + within_s
    while not np.isnan(emulated.widths_us()).all():
        if time.monotonic() > deadline:
            return False
        time.sleep(0.05)
    return True


def goes_on(setup: BenchSetup, recording: CaptureFolder) -> None:
    """Take the recording up; its first rows must stay, and all poses be there in the end."""
    folder = recording.folder
    recording.close()
    before = (folder / "samples.csv").read_text()
    again = open_recording(setup, folder)
    assert again.done >= 2
    capture(setup, again)
    again.close()
    assert (folder / "samples.csv").read_text().startswith(before)
    assert_shows_the_arm(setup, folder)


def assert_shows_the_arm(setup: BenchSetup, folder: Path, hidden: str = "") -> None:
    """Each picture shows the arm where its row commands it to be, to within a servo's half microsecond.

    Of the markers, one may be `hidden`.
    """
    recording = measure_recording(read_recording(folder))
    assert len(recording) == len(PLAN)
    world = paper_world()
    points = marker_positions(setup.arm, recording.q_cmd, world.deviation)
    for row in range(len(recording)):
        wanted = project(world.true_camera, robot_to_board(points[row], world.base_in_board_mm))
        for name, pixel in zip(setup.arm.marker_names, wanted, strict=True):
            seen = recording.markers_px[name][row]
            if name != hidden:
                assert np.linalg.norm(seen - pixel) < 1.5, (row, name, seen, pixel)


def test_without_a_fault_all_poses_are_recorded_and_the_servos_end_detached(
    emulated: EmulatedBench, setup: BenchSetup, recording: CaptureFolder
):
    capture(setup, recording)

    assert detached(emulated, 0.5)
    assert_shows_the_arm(setup, recording.folder)


def test_port_unplugged_in_the_middle_of_a_move(emulated: EmulatedBench, setup: BenchSetup, recording: CaptureFolder):
    with pytest.raises(LinkLostError, match="lost"):
        capture(setup, recording, soon(lambda: emulated.tell("unplug")))

    assert detached(emulated, 3 * SILENCE_S)
    emulated.tell("plug")
    goes_on(setup, recording)


def test_arduino_reset_in_the_middle_of_a_move(emulated: EmulatedBench, setup: BenchSetup, recording: CaptureFolder):
    with pytest.raises(BoardResetError, match="reset"):
        capture(setup, recording, soon(lambda: emulated.tell("reset")))

    assert detached(emulated, 0.5)
    goes_on(setup, recording)


def test_camera_lost(emulated: EmulatedBench, setup: BenchSetup, recording: CaptureFolder):
    with pytest.raises(CameraLostError, match="the stream broke off"):
        capture(setup, recording, soon(lambda: emulated.tell("drop")))

    assert detached(emulated, 0.5)
    goes_on(setup, recording)


def test_stream_frozen(emulated: EmulatedBench, setup: BenchSetup, recording: CaptureFolder):
    with pytest.raises(CameraLostError, match="frozen"):
        capture(setup, recording, soon(lambda: emulated.tell("freeze", True)))

    assert detached(emulated, 0.5)
    emulated.tell("freeze", False)
    goes_on(setup, recording)


def test_frames_late_by_a_second_still_show_the_commanded_pose(
    emulated: EmulatedBench, setup: BenchSetup, recording: CaptureFolder
):
    emulated.tell("late", 1.0)
    try:
        capture(setup, recording)
    finally:
        emulated.tell("late", 0.0)

    assert detached(emulated, 0.5)
    assert_shows_the_arm(setup, recording.folder)


def test_frames_that_begin_to_be_late_in_the_middle_still_show_the_commanded_pose(
    emulated: EmulatedBench, setup: BenchSetup, recording: CaptureFolder
):
    try:
        capture(setup, recording, lambda: emulated.tell("late", 1.0))
    finally:
        emulated.tell("late", 0.0)

    assert detached(emulated, 0.5)
    assert_shows_the_arm(setup, recording.folder)


def test_a_hand_before_late_frames_is_not_taken_for_the_motion(
    emulated: EmulatedBench, setup: BenchSetup, recording: CaptureFolder
):
    """It comes shortly before the third move, but the picture from before that move does not show it yet."""
    fast = replace(setup, motion=setup.motion.model_copy(update={"speed_rad_s": 1.5}))

    def hold_a_hand_there() -> None:
        emulated.tell("hide", "b")
        time.sleep(0.7)

    emulated.tell("late", 1.0)
    try:
        capture(fast, recording, hold_a_hand_there)
    finally:
        emulated.tell("late", 0.0)
        emulated.tell("show", "b")

    assert detached(emulated, 0.5)
    assert_shows_the_arm(setup, recording.folder, hidden="b")


def test_marker_hidden_leaves_its_cells_empty_and_the_others_measured(
    emulated: EmulatedBench, setup: BenchSetup, recording: CaptureFolder
):
    try:
        capture(setup, recording, lambda: emulated.tell("hide", "b"))
    finally:
        emulated.tell("show", "b")

    assert detached(emulated, 0.5)
    measured = measure_recording(read_recording(recording.folder)).markers_px
    seen = {name: np.isfinite(pixels).all(axis=1) for name, pixels in measured.items()}
    np.testing.assert_array_equal(seen["b"], [True, True, False, False, False])
    assert seen["a"].all()
    assert seen["c"].all()
    assert seen["f"].all()


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    with mounted(tmp_path, 24) as disk:
        yield disk


def test_disk_full(emulated: EmulatedBench, setup: BenchSetup, small_disk: Path):
    recording = open_recording(setup, small_disk / "recording")
    filler = small_disk / "film"

    def fill() -> None:
        status = os.statvfs(small_disk)
        filler.write_bytes(bytes(status.f_bavail * status.f_frsize))

    with pytest.raises(JobError, match="No space left on device"):
        capture(setup, recording, fill)

    assert detached(emulated, 0.5)
    assert len(read_recording(recording.folder)) == 2
    filler.unlink()
    goes_on(setup, recording)


class Host:
    """`armtwin capture` in a process of its own."""

    def __init__(self, bench_file: Path, folder: Path) -> None:
        plan = folder / "plan.csv"
        write_plan(plan, PLAN)
        self.folder = folder / "recording"
        code = "from armtwin.scenarios.commands.capture import capture_command; import sys; from pathlib import Path; "
        code += "capture_command(sys.argv[1], sys.argv[2], Path(sys.argv[3]))"
        self._command = [sys.executable, "-c", code, str(bench_file), str(plan), str(self.folder)]
        self.process = subprocess.Popen(self._command, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL)

    def wait_for_rows(self, rows: int) -> None:
        samples = self.folder / "samples.csv"
        deadline = time.monotonic() + 60.0
        while not samples.exists() or len(samples.read_text().splitlines()) < rows + 1:
            assert self.process.poll() is None, self.process.communicate()
            assert time.monotonic() < deadline
            time.sleep(0.05)


@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_host_ended_by_a_signal(emulated: EmulatedBench, setup: BenchSetup, tmp_path: Path, how: signal.Signals):
    host = Host(emulated.bench_file, tmp_path)
    host.wait_for_rows(2)
    assert not np.isnan(emulated.widths_us()[:3]).any()

    host.process.send_signal(how)
    host.process.communicate(timeout=30.0)

    assert host.process.returncode != 0
    assert detached(emulated, 3 * SILENCE_S if how is signal.SIGKILL else 0.5)
    assert len(read_recording(host.folder)) >= 2
    again = open_recording(setup, host.folder)
    goes_on(setup, again)


@pytest.fixture
def slow_bench_file(emulated: EmulatedBench) -> Path:
    """Return the bench with moves that take three seconds each."""
    table = tomllib.loads(emulated.bench_file.read_text())
    table["motion"]["speed_rad_s"] = 0.1
    slow = emulated.bench_file.with_name("slow.toml")
    slow.write_text(tomli_w.dumps(table))
    return slow


def test_host_halted_in_the_middle_of_a_move_for_longer_than_the_board_waits(
    emulated: EmulatedBench, setup: BenchSetup, slow_bench_file: Path, tmp_path: Path
):
    """As by a laptop that is shut: the limp arm stands still where it hung, which is no pose."""
    host = Host(slow_bench_file, tmp_path)
    host.wait_for_rows(2)
    time.sleep(MIDDLE_OF_A_MOVE_S)
    host.process.send_signal(signal.SIGSTOP)
    assert detached(emulated, 3 * SILENCE_S)
    host.process.send_signal(signal.SIGCONT)
    _, said = host.process.communicate(timeout=30.0)

    assert host.process.returncode != 0
    assert "the board has detached the servos by itself (silence)" in said.decode()
    assert "the servos are detached" in said.decode()
    assert "run the same command again" in said.decode()
    assert len(read_recording(host.folder)) == 2
    goes_on(setup, open_recording(setup, host.folder))


def test_host_does_not_say_of_an_unplugged_board_that_it_is_detached(
    emulated: EmulatedBench, slow_bench_file: Path, tmp_path: Path
):
    host = Host(slow_bench_file, tmp_path)
    host.wait_for_rows(2)
    emulated.tell("unplug")
    try:
        _, said = host.process.communicate(timeout=30.0)
    finally:
        assert detached(emulated, 3 * SILENCE_S)
        emulated.tell("plug")

    assert "the board does not answer and detaches the servos itself" in said.decode()
    assert "2 of 5 poses are kept" in said.decode()
    assert "the servos are detached" not in said.decode()
