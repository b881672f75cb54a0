"""Inverse kinematics of random arms of one to six joints, and the one Jacobian that it stands on."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from armtwin.models import kinematics
from armtwin.models.arm import Arm, nominal_arm
from armtwin.models.errors import UnreachablePoseError
from armtwin.models.inverse_kinematics import inverse
from armtwin.models.kinematics import Deviation, forward, forward_jacobian, marker_positions, path_to
from armtwin.models.trajectories import paper_trajectories


def drawn(seed: int, n: int) -> tuple[np.random.Generator, Arm]:
    rng = np.random.default_rng(seed)
    return rng, Arm("mine", rng.uniform(30.0, 120.0, n), np.zeros(2))


@given(seed=st.integers(0, 10_000), n=st.integers(1, 6))
@settings(max_examples=25, deadline=None)
def test_the_commands_found_for_a_pose_bring_the_tip_there(seed: int, n: int):
    rng, arm = drawn(seed, n)
    wanted = forward(arm, rng.uniform(-1.2, 1.2, (2, n)))
    found = forward(arm, inverse(arm, wanted))
    np.testing.assert_allclose(found[:, :2], wanted[:, :2], atol=2e-3)
    if n >= 3:
        np.testing.assert_allclose(np.exp(1j * found[:, 2]), np.exp(1j * wanted[:, 2]), atol=1e-4)


@given(seed=st.integers(0, 10_000), n=st.integers(1, 6))
@settings(max_examples=50, deadline=None)
def test_the_jacobian_of_every_marker_is_that_of_central_differences(seed: int, n: int):
    rng, arm = drawn(seed, n)
    q, step = rng.uniform(-np.pi, np.pi, (3, n)), 1e-5
    _, by_joint = forward_jacobian(arm, q)
    for joint in range(n):
        h = np.eye(n)[joint] * step
        slope = (marker_positions(arm, q + h) - marker_positions(arm, q - h)) / (2 * step)
        np.testing.assert_allclose(by_joint[..., joint], slope, atol=1e-5)


def test_the_commands_of_a_deviated_arm_bring_the_deviated_arm_there():
    rng, arm = drawn(3, 4)
    delta = Deviation(np.array([2.0, -1.0, 0.5, 1.0]), np.array([0.02, -0.03, 0.01, 0.0]))
    wanted = forward(arm, rng.uniform(-1.0, 1.0, (3, 4)), delta)
    np.testing.assert_allclose(forward(arm, inverse(arm, wanted, delta), delta)[:, :2], wanted[:, :2], atol=2e-3)


def test_a_path_stays_in_one_branch():
    arm = Arm("two", np.array([110.0, 90.0]), np.zeros(2))
    angle = np.linspace(0.0, 2 * np.pi, 40)
    path = np.stack([120 + 15 * np.cos(angle), 60 + 15 * np.sin(angle), 0 * angle], axis=-1)
    assert np.abs(np.diff(inverse(arm, path), axis=0)).max() < 0.1


def test_the_papers_arm_takes_the_closed_form():
    line = paper_trajectories()["line"]
    np.testing.assert_array_equal(inverse(nominal_arm(), line), kinematics.inverse(nominal_arm(), line))


@pytest.mark.parametrize("n", [1, 2, 4, 6])
def test_a_pose_out_of_reach_is_named_with_what_is_missing(n: int):
    arm = Arm("mine", np.full(n, 50.0), np.zeros(2))
    poses = np.array([[50.0 * n, 0.0, 0.0], [50.0 * n + 10.0, 0.0, 0.0]])
    with pytest.raises(UnreachablePoseError, match=r"pose 1 \(x .*the tip comes no nearer than 10\.00 mm"):
        inverse(arm, poses)


def test_a_pose_that_is_no_number_is_out_of_reach():
    with pytest.raises(UnreachablePoseError, match=r"pose 0 .* it is no number"):
        inverse(Arm("two", np.array([50.0, 50.0]), np.zeros(2)), np.array([[np.nan, 0.0, 0.0]]))


def test_the_path_to_the_corner_ends_with_the_last_link_without_its_offset():
    assert path_to(nominal_arm(), "a") == ()
    assert path_to(nominal_arm(), "f") == ((0, 0), (1, 1), (2, 2))
    assert path_to(nominal_arm(), "e") == ((0, 0), (1, 1), (3, 2))
