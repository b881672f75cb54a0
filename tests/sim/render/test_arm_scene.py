"""The arm's solids follow its lengths, and its discs lie where its kinematics put the markers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from armtwin.models.arm import nominal_arm
from armtwin.models.coordinate_frames import robot_to_board
from armtwin.models.errors import InputError
from armtwin.models.kinematics import marker_positions
from armtwin.sim.render import arm_parts, marker_bodies, planar_arm_poses, robot_bodies_on_board

LENGTHS = np.array([120.0, 121.7, 38.0, 6.73])
BASE = np.array([55.0, -15.0, -80.87])


def disc_centres(lengths: np.ndarray, poses: dict[str, np.ndarray], **changes: object) -> dict[str, np.ndarray]:
    """Centre of each marker's sticker, carried by its body."""
    centres = {}
    for part in arm_parts(lengths, **changes):  # type: ignore[arg-type]
        if part.name.startswith("marker "):
            assert part.body is not None
            assert np.all(part.mesh.vertices[:, 2] == 0.0)
            middle = 0.5 * (part.mesh.vertices.min(axis=0) + part.mesh.vertices.max(axis=0))
            T = poses[part.body]
            centres[part.name.removeprefix("marker ")] = T[:3, :3] @ middle + T[:3, 3]
    return centres


@pytest.mark.parametrize("lengths", [LENGTHS, LENGTHS + np.array([6.7, 4.6, -0.7, 1.0])])
@pytest.mark.parametrize("q", [[0.0, 0.0, 0.0], [0.3, -0.5, 0.8], [-0.7, 0.2, -0.1]])
def test_discs_lie_on_the_markers_in_the_plane_of_the_arm(lengths: np.ndarray, q: list[float]) -> None:
    arm = replace(nominal_arm(), link_lengths_mm=lengths)
    expected = robot_to_board(marker_positions(arm, np.array([q]))[0], BASE)
    centres = disc_centres(lengths, robot_bodies_on_board(planar_arm_poses(lengths, q), BASE))
    assert list(centres) == list(arm.marker_names)
    assert np.array(list(centres.values())) == pytest.approx(expected, abs=1e-9)
    assert np.allclose(expected[:, 2], BASE[2])


def test_nothing_stands_before_the_plane_of_the_markers() -> None:
    assert max(part.mesh.vertices[:, 2].max() for part in arm_parts(LENGTHS)) == 0.0


def test_an_offset_sticker_moves_in_its_bodys_frame() -> None:
    poses = planar_arm_poses(LENGTHS, [0.0, 0.0, 0.0])
    straight = disc_centres(LENGTHS, poses)
    moved = disc_centres(LENGTHS, poses, marker_offsets_mm={"b": (1.5, 0.0)})
    # At the zero pose link 1 stands up, so that its x is the robot's y.
    assert moved["b"] - straight["b"] == pytest.approx([0.0, 1.5, 0.0], abs=1e-9)
    assert all(np.array_equal(moved[m], straight[m]) for m in "acf")


@pytest.mark.parametrize("n", [1, 2, 4, 6])
def test_other_arms_letter_their_markers(n: int) -> None:
    lengths = np.full(n, 60.0)
    poses = planar_arm_poses(lengths, np.zeros(n))
    centres = disc_centres(lengths, poses, n_joints=n)
    assert list(centres) == list("abcdefg"[: n + 1])
    assert np.array(list(centres.values()))[:, 0] == pytest.approx(60.0 * np.arange(n + 1), abs=1e-9)


def test_the_first_marker_rides_on_the_base_and_the_others_on_the_ends_of_the_links() -> None:
    assert marker_bodies(("a", "b", "c", "f")) == {"a": "base", "b": "end1", "c": "end2", "f": "end3"}


def test_a_number_of_lengths_that_fits_no_arm_is_refused() -> None:
    with pytest.raises(InputError, match="5 were given"):
        arm_parts(np.ones(5), n_joints=3)
    with pytest.raises(InputError, match="0 were given"):
        arm_parts([])


def test_an_offset_of_an_unknown_marker_is_refused() -> None:
    with pytest.raises(InputError, match="names d; this arm's markers are a, b, c, f"):
        arm_parts(LENGTHS, {"d": (1.0, 0.0)})
