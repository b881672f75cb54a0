"""Markers told apart: right where they can be, and never silently wrong where they cannot."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from armtwin.calib.markers import Disc, MarkerReading, identify
from armtwin.models.arm import Arm, nominal_arm
from armtwin.models.camera import Camera, project, project_jacobian
from armtwin.models.coordinate_frames import robot_to_board
from armtwin.models.kinematics import Deviation, marker_positions

Array = NDArray[np.float64]

PLANE_MM = -80.87
BASE_MM = np.array([40.0, -33.0, PLANE_MM])
# Table 4's second column: what the real arm differed by.
TABLE_4 = Deviation(np.array([6.7015, 4.5704, -0.7074, 1.0208]), np.radians([1.1354, 1.0037, 4.7563]))
Q = np.array([0.1, 0.2, 0.3])
# A, B and C 120 mm apart, and a pose in which no other naming has the right lengths.
EQUILATERAL, UNLIKE = np.array([0.0, np.pi / 6.0, 0.3]), np.array([0.0, 0.0, 0.9])


def anywhere(rng: np.random.Generator) -> Array:
    """Joint angles, (3,) rad, that keep the arm in the picture."""
    return rng.uniform([-0.3, 0.0, -0.6], [0.3, 0.9, 0.9])


def disc_at(camera: Camera, place_mm: Array, radius_mm: float = 7.0) -> Disc:
    radius = radius_mm * np.sqrt(abs(np.linalg.det(project_jacobian(camera, place_mm[None])[0, :, :2])))
    centre = project(camera, place_mm[None])[0]
    return Disc(centre, 1e-4 * np.eye(2), np.full(2, radius), 170.0, 0.9, 1.0, np.empty((0, 2)))


def markers(arm: Arm, q: Array = Q, delta: Deviation | None = TABLE_4) -> Array:
    """(M, 3) board places of an arm's markers."""
    return robot_to_board(marker_positions(arm, q[None], delta)[0], BASE_MM)


def seen(camera: Camera, places: Array, rng: np.random.Generator) -> tuple[Disc, ...]:
    """The discs of these places, in no order."""
    return tuple(disc_at(camera, places[i]) for i in rng.permutation(len(places)))


def assert_right(reading: MarkerReading, camera: Camera, places: Array, names: tuple[str, ...]) -> None:
    for name, truth in zip(names, project(camera, places), strict=True):
        if name in reading.discs:
            assert reading.pixels[name] == pytest.approx(truth, abs=1e-9), f"marker {name} was taken for another"


@pytest.fixture(scope="module")
def arm() -> Arm:
    return nominal_arm()


def test_the_whole_arm_is_named_with_the_command(webcam: Camera, arm: Arm, rng: np.random.Generator) -> None:
    for _ in range(40):
        places = markers(arm, anywhere(rng))
        q = Q  # of another pose: a missed command must not name markers wrongly
        reading = identify(seen(webcam, places, rng), arm, webcam, PLANE_MM, q)
        assert_right(reading, webcam, places, arm.marker_names)


def test_lengths_alone_name_an_arm_whose_chain_fits_one_way(webcam: Camera, arm: Arm, rng: np.random.Generator) -> None:
    places = markers(arm, UNLIKE)
    reading = identify(seen(webcam, places, rng), arm, webcam, PLANE_MM)
    assert reading.is_complete
    assert_right(reading, webcam, places, arm.marker_names)


def test_an_equilateral_pose_is_ambiguous_until_the_command_is_known(
    webcam: Camera, arm: Arm, rng: np.random.Generator
) -> None:
    places = markers(arm, EQUILATERAL, None)
    discs = seen(webcam, places, rng)
    without = identify(discs, arm, webcam, PLANE_MM)
    assert "ambiguous" in without.status.values()
    assert any("explain the picture alike" in message for message in without.messages)
    assert identify(discs, arm, webcam, PLANE_MM, EQUILATERAL).is_complete


@pytest.mark.parametrize("gone", [0, 1, 2, 3])
def test_a_hidden_marker_is_reported_and_the_others_kept(
    webcam: Camera, arm: Arm, rng: np.random.Generator, gone: int
) -> None:
    places = markers(arm, UNLIKE)
    reading = identify(seen(webcam, np.delete(places, gone, axis=0), rng), arm, webcam, PLANE_MM, UNLIKE, BASE_MM)
    name = arm.marker_names[gone]
    assert reading.status[name] == "hidden"
    assert np.isnan(reading.pixels[name]).all()
    assert any(message.startswith(f"marker {name} is hidden") for message in reading.messages)
    assert len(reading.discs) == 3
    assert_right(reading, webcam, places, arm.marker_names)


def test_where_f_could_be_c_neither_is_named(webcam: Camera, arm: Arm, rng: np.random.Generator) -> None:
    places = markers(arm, np.array([0.0, 0.0, 0.16]))  # F is as far from B as C is
    reading = identify(seen(webcam, np.delete(places, 2, axis=0), rng), arm, webcam, PLANE_MM)
    assert not {"c", "f"} & set(reading.discs)


def test_the_base_of_other_pictures_names_a_alone(webcam: Camera, arm: Arm) -> None:
    alone = (disc_at(webcam, markers(arm)[0]),)
    assert not identify(alone, arm, webcam, PLANE_MM, Q).discs
    assert set(identify(alone, arm, webcam, PLANE_MM, Q, BASE_MM).discs) == {"a"}


def test_a_doubled_marker_is_ambiguous(webcam: Camera, arm: Arm, rng: np.random.Generator) -> None:
    places = markers(arm)
    double = places[3] + np.array([3.0, 3.0, 0.0])
    reading = identify(seen(webcam, np.vstack([places, double]), rng), arm, webcam, PLANE_MM, Q)
    assert reading.status == {"a": "seen", "b": "seen", "c": "seen", "f": "ambiguous"}
    assert_right(reading, webcam, places, arm.marker_names)


def test_red_clutter_anywhere_is_never_taken_for_a_marker(webcam: Camera, arm: Arm, rng: np.random.Generator) -> None:
    for _ in range(40):
        q = anywhere(rng)
        places = markers(arm, q)
        clutter = np.column_stack([rng.uniform(-120.0, 150.0, 3), rng.uniform(-100.0, 120.0, 3), np.full(3, PLANE_MM)])
        shown = np.delete(places, rng.integers(4), axis=0) if rng.random() < 0.5 else places
        away = np.linalg.norm(clutter[:, None] - places[None], axis=2).min(axis=1) > 25.0
        reading = identify(seen(webcam, np.vstack([shown, clutter[away]]), rng), arm, webcam, PLANE_MM, q, BASE_MM)
        assert_right(reading, webcam, places, arm.marker_names)


def test_a_sliver_in_a_marker_s_place_is_not_the_marker(webcam: Camera, arm: Arm) -> None:
    places = markers(arm)
    discs = (*(disc_at(webcam, p) for p in places[:3]), disc_at(webcam, places[3] + [4.0, 0.0, 0.0], 2.0))
    reading = identify(discs, arm, webcam, PLANE_MM, Q)
    assert reading.status["f"] == "hidden"


def test_a_missed_command_costs_no_marker(webcam: Camera, arm: Arm, rng: np.random.Generator) -> None:
    places = markers(arm, UNLIKE)
    reading = identify(seen(webcam, places, rng), arm, webcam, PLANE_MM, np.array([0.3, 0.8, -0.6]))
    assert reading.is_complete


def test_a_bumped_camera_costs_no_marker(webcam: Camera, arm: Arm, rng: np.random.Generator) -> None:
    places = markers(arm)
    reading = identify(seen(webcam, places, rng), arm, webcam, PLANE_MM, Q, BASE_MM + np.array([25.0, 10.0, 0.0]))
    assert reading.is_complete


def test_one_disc_alone_is_nobody(webcam: Camera, arm: Arm) -> None:
    reading = identify((disc_at(webcam, markers(arm)[1]),), arm, webcam, PLANE_MM, Q)
    assert not reading.discs
    assert set(reading.status.values()) == {"ambiguous"}


def test_no_disc_at_all_hides_every_marker(webcam: Camera, arm: Arm) -> None:
    reading = identify((), arm, webcam, PLANE_MM, Q)
    assert set(reading.status.values()) == {"hidden"}
    assert "0 discs in the picture" in reading.messages[0]


def test_a_partly_seen_marker_is_mentioned(webcam: Camera, arm: Arm) -> None:
    whole = [disc_at(webcam, p) for p in markers(arm)]
    half = Disc(whole[2].centre, 4e-2 * np.eye(2), whole[2].axes, 170.0, 0.9, 0.6, np.empty((0, 2)))
    reading = identify((whole[0], whole[1], half, whole[3]), arm, webcam, PLANE_MM, Q)
    assert reading.messages == ("marker c: 60% of its outline is seen",)


def test_a_chain_of_two_joints_is_named(webcam: Camera, rng: np.random.Generator) -> None:
    arm = Arm("chain", np.array([90.0, 60.0]), np.zeros(2))
    q = np.array([1.2, 0.5])
    places = markers(arm, q, None)
    reading = identify(seen(webcam, places, rng), arm, webcam, PLANE_MM, q)
    assert reading.is_complete
    assert_right(reading, webcam, places, arm.marker_names)
