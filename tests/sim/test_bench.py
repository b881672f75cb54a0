from collections.abc import Iterator

import cv2
import numpy as np
import pytest

from armtwin.models.bench import Bench
from armtwin.models.camera import project
from armtwin.models.errors import InputError, JobError
from armtwin.models.kinematics import Deviation
from armtwin.models.world import World
from armtwin.sim.bench import SimulatedBench
from armtwin.sim.sensor import IDEAL
from tests.support.worlds import flat_world, small_camera, with_effect

POSE = np.array([0.1, 0.2, -0.3])
DEVIATION = Deviation(np.array([4.0, -3.0, 2.0, 0.5]), np.array([0.05, -0.03, 0.08]))


def opened(world: World, **options: object) -> SimulatedBench:
    bench = SimulatedBench(small_camera(world), sensor=IDEAL, shadows=False, **options)  # type: ignore[arg-type]
    bench.connect()
    return bench


@pytest.fixture
def bench() -> Iterator[SimulatedBench]:
    made = opened(flat_world(DEVIATION))
    yield made
    made.close()


def red_blobs(image: np.ndarray) -> np.ndarray:
    """(N, 2) centroids of the red discs, px."""
    red = image[..., 2].astype(int) - image[..., 1] > 100
    count, _, _, centroids = cv2.connectedComponentsWithStats(red.astype(np.uint8))
    return np.asarray(centroids)[1:count]


def test_it_is_a_bench(bench: SimulatedBench) -> None:
    assert isinstance(bench, Bench)


def test_the_picture_shows_the_markers_where_they_truly_are(bench: SimulatedBench) -> None:
    bench.move(POSE)
    blobs = red_blobs(bench.capture().image)
    truth = bench.true_pixels()
    for name in "abcf":
        assert np.linalg.norm(blobs - truth[name], axis=1).min() < 0.2
    assert len(blobs) == 4


def test_the_same_seed_gives_the_same_picture() -> None:
    pictures = []
    for _ in range(2):
        bench = SimulatedBench(small_camera(flat_world()), seed=3)
        bench.connect()
        bench.move(POSE)
        pictures.append(bench.capture().image)
        bench.close()
    np.testing.assert_array_equal(*pictures)


def test_a_frame_says_when_it_was_taken_and_when_its_pose_was_commanded(bench: SimulatedBench) -> None:
    assert bench.capture().commanded_s is None
    bench.move(POSE)
    bench.move(POSE)
    frame = bench.capture()
    assert (frame.commanded_s, frame.time_s) == (1.5, 3.0)


def test_a_sticker_off_its_axis_is_drawn_off_its_axis() -> None:
    bench = opened(with_effect(flat_world(), "marker_offset", {"x_mm": 4.0, "y_mm": 3.0, "body": 1}, marker="b"))
    bench.move(POSE)
    blobs = red_blobs(bench.capture().image)
    assert np.linalg.norm(blobs - bench.true_pixels()["b"], axis=1).min() < 0.2
    bench.close()


def test_a_bumped_camera_sees_the_markers_elsewhere() -> None:
    bench = opened(with_effect(flat_world(), "camera_moved", {"translation_x_mm": 5.0, "from_sample": 1}))
    seen = []
    for _ in range(2):
        bench.move(POSE)
        blobs = red_blobs(bench.capture().image)
        assert np.linalg.norm(blobs - bench.true_pixels()["f"], axis=1).min() < 0.2
        seen.append(bench.true_pixels()["f"])
    assert seen[1][0] - seen[0][0] > 5.0
    bench.close()


def test_stale_pictures_show_the_pose_before() -> None:
    bench = opened(with_effect(flat_world(), "command_shift", {"rows": 1}))
    bench.move(POSE)
    before = bench.capture().image
    bench.move(-POSE)
    np.testing.assert_array_equal(bench.capture().image, before)
    bench.close()


def test_pictures_of_the_future_are_refused() -> None:
    with pytest.raises(InputError, match="rows must be >= 0"):
        SimulatedBench(with_effect(flat_world(), "command_shift", {"rows": -1}))


def test_the_chessboard_is_found_where_it_is_held(bench: SimulatedBench) -> None:
    T = np.eye(4)
    T[:3, 3] = [5.0, -8.0, -60.0]
    grey = cv2.cvtColor(bench.capture_board(T).image, cv2.COLOR_BGR2GRAY)
    found, corners = cv2.findChessboardCornersSB(grey, (9, 6))
    assert found
    first = project(bench.world.true_camera, np.array([[5.0, -8.0, -60.0]]))[0]
    assert np.linalg.norm(corners.reshape(-1, 2) - first, axis=1).min() < 0.2


def test_a_gauge_lies_in_the_arms_plane(bench: SimulatedBench) -> None:
    T = bench.gauge_placement(150.0, 60.0, 0.4)
    blobs = red_blobs(bench.capture_gauge(40.0, T).image)
    ends = project(bench.world.true_camera, (T @ np.array([[-20.0, 0, 0, 1], [20.0, 0, 0, 1]]).T).T[:, :3])
    assert T[2, 3] == bench.world.base_in_board_mm[2]
    for end in ends:
        assert np.linalg.norm(blobs - end, axis=1).min() < 0.2


def test_a_bench_that_is_not_connected_says_so() -> None:
    with pytest.raises(JobError, match="not connected"):
        SimulatedBench(flat_world()).move(POSE)


def test_closing_twice_is_harmless(bench: SimulatedBench) -> None:
    bench.close()
    bench.close()
