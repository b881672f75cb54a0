"""The bench against the real firmware in the emulator and a stream whose scene follows the pulses."""

import threading
import time
from collections import deque
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from armtwin.hardware.bench.bench_file import BenchSetup
from armtwin.hardware.bench.hardware_bench import DetachedError, HardwareBench, MotionError
from armtwin.hardware.bench.tables import CameraSettings
from armtwin.hardware.emulator import FirmwareEmulator, missing_packages
from armtwin.hardware.emulator.mjpeg import MjpegServer, to_jpeg
from armtwin.models.bench import Bench
from armtwin.models.camera import Camera
from armtwin.models.errors import InputError, JobError
from tests.support.bench import Scene

pytestmark = [
    pytest.mark.avr,
    pytest.mark.skipif(bool(missing_packages()), reason=missing_packages() or "present"),
]


class Filmed:
    """Turns the scene's bar with the first servo's pulses and streams it, late if that is wanted."""

    def __init__(self, board: FirmwareEmulator) -> None:
        self.server = MjpegServer()
        self.spoil = lambda image: image
        self.late_s = 0.0
        self.scene_stands = False  # as where the servos have no supply
        self.scene = Scene()
        self._board = board
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self) -> None:
        queue: deque[tuple[float, bytes]] = deque()
        while not self._stop.wait(0.02):
            width = self._board.widths_us()[0]
            if np.isfinite(width) and not self.scene_stands:
                self.scene.angle_rad = round((width - 1500.0) / 636.62, 2)
            queue.append((time.monotonic() + self.late_s, to_jpeg(self.spoil(self.scene.picture()))))
            while queue and queue[0][0] <= time.monotonic():
                self.server.publish(queue.popleft()[1])

    def close(self) -> None:
        self._stop.set()
        self._thread.join()
        self.server.close()


@pytest.fixture
def board() -> Iterator[FirmwareEmulator]:
    with FirmwareEmulator() as emulator:
        yield emulator


@pytest.fixture
def filmed(board: FirmwareEmulator) -> Iterator[Filmed]:
    running = Filmed(board)
    yield running
    running.close()


@pytest.fixture
def wired(setup: BenchSetup, board: FirmwareEmulator, filmed: Filmed) -> BenchSetup:
    camera = setup.camera
    small = Camera(640, 360, camera.K, camera.lens, camera.R_board_camera, camera.t_board_camera_mm)
    source = CameraSettings(source=filmed.server.url, calibration="camera.yaml", arm_plane_z_mm=-80.87)
    fast = setup.motion.model_copy(update={"start_speed_rad_s": 1.0})
    settle = setup.settle.model_copy(update={"onset_s": 0.3})
    return replace(setup, port=board.port, camera=small, camera_settings=source, motion=fast, settle=settle)


@pytest.fixture
def bench(wired: BenchSetup) -> Iterator[HardwareBench]:
    with HardwareBench(wired) as connected:
        yield connected


@pytest.fixture
def late(wired: BenchSetup, filmed: Filmed) -> Iterator[HardwareBench]:
    """Return the bench with a stream that is more than half a second behind, in which a move may show late."""
    filmed.late_s = 0.6
    time.sleep(2 * filmed.late_s)
    patient = replace(wired, settle=wired.settle.model_copy(update={"onset_s": 1.5}))
    with HardwareBench(patient) as connected:
        yield connected


def angle_shown(image: np.ndarray) -> float:
    """Where the scene's red bar points, rad."""
    rows, columns = np.nonzero(image[..., 2].astype(int) - image[..., 0] > 90)
    return float(np.arctan2(rows.mean() - image.shape[0] / 2, columns.mean() - image.shape[1] / 2))


def hand(image: np.ndarray) -> np.ndarray:
    """Put something before the picture's corner, clear of the bar."""
    held = image.copy()
    held[:60, :60] = 128
    return held


def limp(board: FirmwareEmulator) -> bool:
    return board.wait_until(lambda: bool(np.isnan(board.widths_us()).all()), 2.0)


def test_is_a_bench(wired: BenchSetup):
    assert isinstance(HardwareBench(wired), Bench)


def test_connecting_sends_no_pulse(bench: HardwareBench, board: FirmwareEmulator):
    assert np.isnan(board.widths_us()).all()
    assert board.drain() == []


def test_a_move_ends_with_the_mapped_pulses_on_the_pins(bench: HardwareBench, board: FirmwareEmulator):
    bench.move(np.array([0.2, 0.1, -0.1]))

    np.testing.assert_allclose(
        board.widths_us()[:3], bench.setup.servo_map.pulses_us(np.array([0.2, 0.1, -0.1])), atol=1.0
    )


def test_the_first_pulses_are_those_of_the_rest_pose_and_no_step_is_a_jump(
    bench: HardwareBench, board: FirmwareEmulator
):
    bench.move(np.array([0.9, 0.0, 0.0]))

    widths = [pulse.width_us for pulse in board.drain() if pulse.servo == 0]
    assert widths[0] == pytest.approx(1500.0, abs=1.0)
    assert np.abs(np.diff(widths)).max() <= 41.0  # the firmware's slew limit is 40 us a period


def test_a_picture_shows_the_arm_where_it_was_moved(bench: HardwareBench):
    bench.move(np.array([0.3, 0.0, 0.0]))

    assert angle_shown(bench.capture().image) == pytest.approx(0.3, abs=0.01)


def test_a_late_stream_does_not_hide_that_arming_moves_the_arm(late: HardwareBench, filmed: Filmed):
    filmed.scene.angle_rad = 0.15  # the limp arm hangs off the rest pose, which is the first pose too
    time.sleep(2 * filmed.late_s)
    late.move(np.array([0.0, 0.0, 0.0]))

    assert angle_shown(late.capture().image) == pytest.approx(0.0, abs=0.01)


@pytest.mark.parametrize("before_the_move_s", [2.0, 0.3])
def test_a_late_stream_in_which_something_else_changes_still_shows_the_pose(
    late: HardwareBench, filmed: Filmed, before_the_move_s: float
):
    """Also where the change itself is still on its way when the move begins."""
    late.move(np.array([0.2, 0.0, 0.0]))
    late.move(np.array([0.3, 0.0, 0.0]))
    filmed.spoil = hand
    time.sleep(before_the_move_s)
    late.move(np.array([0.1, 0.0, 0.0]))

    assert angle_shown(late.capture().image) == pytest.approx(0.1, abs=0.01)


def test_a_limp_arm_is_no_pose_although_it_stands_still(wired: BenchSetup):
    slow = replace(wired, settle=wired.settle.model_copy(update={"still_s": 1.0}))
    with HardwareBench(slow) as bench:
        bench.move(np.array([0.1, 0.0, 0.0]))
        threading.Timer(0.5, bench.link.detach).start()

        with pytest.raises(DetachedError, match="the board has detached the servos by itself"):
            bench.move(np.array([0.3, 0.0, 0.0]))


def test_a_board_that_detached_between_two_moves_is_said_so(bench: HardwareBench):
    bench.move(np.array([0.1, 0.0, 0.0]))
    bench.link.detach()

    with pytest.raises(DetachedError, match="the board has detached the servos by itself"):
        bench.move(np.array([0.3, 0.0, 0.0]))
    with pytest.raises(DetachedError):
        bench.capture()


def test_an_arm_that_never_moves_in_the_picture_ends_the_capture(bench: HardwareBench, filmed: Filmed):
    filmed.scene_stands = True
    bench.move(np.array([0.1, 0.0, 0.0]))
    bench.move(np.array([0.2, 0.0, 0.0]))

    with pytest.raises(MotionError, match="the picture showed nothing of the last 3 moves"):
        bench.move(np.array([0.1, 0.0, 0.0]))


def test_a_picture_without_any_marker_is_refused_before_anything_is_armed(wired: BenchSetup, board: FirmwareEmulator):
    with HardwareBench(wired, lambda image, q: {}) as blind:
        with pytest.raises(JobError, match=r"no marker is in the picture \(a, b, c, f are looked for\)"):
            blind.move(np.array([0.1, 0.0, 0.0]))
        assert board.drain() == []


def test_time_runs_from_command_to_picture_to_command(bench: HardwareBench):
    bench.move(np.array([0.1, 0.0, 0.0]))
    first = bench.capture()
    bench.move(np.array([0.2, 0.0, 0.0]))
    second = bench.capture()

    assert first.commanded_s is not None
    assert second.commanded_s is not None
    assert 0.0 < first.commanded_s < first.time_s < second.commanded_s < second.time_s


@pytest.mark.parametrize("q", [[1.3, 0.0, 0.0], [0.0, np.nan, 0.0], [0.0, 0.0]])
def test_a_pose_outside_the_limits_arms_nothing(bench: HardwareBench, board: FirmwareEmulator, q: list[float]):
    with pytest.raises(InputError):
        bench.move(np.array(q))

    assert board.drain() == []


def test_too_long_a_step_is_not_sent(bench: HardwareBench, board: FirmwareEmulator):
    bench.move(np.array([0.0, 0.0, 0.0]))
    before = board.widths_us()

    with pytest.raises(InputError, match=r"joint 1 turns 0\.6000 rad in one step"):
        bench.move(np.array([0.6, 0.0, 0.0]))

    np.testing.assert_allclose(board.widths_us(), before, atol=1.0)


def test_closing_detaches_and_is_safe_twice(wired: BenchSetup, board: FirmwareEmulator):
    bench = HardwareBench(wired)
    bench.connect()
    bench.move(np.array([0.1, 0.0, 0.0]))
    bench.close()
    bench.close()

    assert bench.detached
    assert limp(board)


def test_a_board_that_cannot_be_reached_is_not_said_to_be_detached(wired: BenchSetup, board: FirmwareEmulator):
    bench = HardwareBench(wired)
    bench.connect()
    assert bench.detached  # it was never armed
    bench.move(np.array([0.1, 0.0, 0.0]))
    board.unplug()
    bench.close()
    bench.close()

    assert not bench.detached


def test_a_board_that_was_reset_is_detached(bench: HardwareBench, board: FirmwareEmulator):
    bench.move(np.array([0.1, 0.0, 0.0]))
    board.reset()
    bench.close()

    assert bench.detached


def test_an_error_in_the_callers_block_detaches(wired: BenchSetup, board: FirmwareEmulator):
    def fail_after_a_move() -> None:
        with HardwareBench(wired) as bench:
            bench.move(np.array([0.1, 0.0, 0.0]))
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fail_after_a_move()

    assert limp(board)


def test_a_black_picture_is_refused_before_anything_is_armed(
    wired: BenchSetup, board: FirmwareEmulator, filmed: Filmed
):
    filmed.spoil = lambda image: (image // 40).astype(np.uint8)

    with pytest.raises(JobError, match="the picture is black"):
        HardwareBench(wired).connect()

    assert board.drain() == []


def test_a_camera_that_is_not_there_leaves_the_port_free(wired: BenchSetup, filmed: Filmed):
    gone = wired.camera_settings.model_copy(update={"source": filmed.server.url + "x"})
    with pytest.raises(InputError, match="there is no such page"):
        HardwareBench(replace(wired, camera_settings=gone)).connect()

    with HardwareBench(wired) as bench:
        assert bench.hello.n_servos == 6
