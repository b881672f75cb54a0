import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from armtwin.models.arm import Arm, nominal_arm
from armtwin.models.errors import InputError, UnreachablePoseError
from armtwin.models.kinematics import (
    Deviation,
    complex_links,
    forward,
    forward_jacobian,
    inverse,
    link_angles,
    marker_positions,
    wrap,
)
from armtwin.models.trajectories import circle, paper_trajectories

ARM = nominal_arm()
TABLE_4 = Deviation(np.array([6.7015, 4.5704, -0.7074, 1.0208]), np.radians([1.1354, 1.0037, 4.7563]))
angle = st.floats(-3.1, 3.1)
offset = st.floats(-0.2, 0.2)
stretch = st.floats(-8.0, 8.0)
deviations = st.builds(
    lambda lengths, joints: Deviation(np.array(lengths), np.array(joints)),
    st.tuples(stretch, stretch, stretch, st.floats(-4.0, 4.0)),
    st.tuples(offset, offset, offset),
)


def test_the_zero_pose_is_that_of_figure_1():
    a, b, c, f = marker_positions(ARM, np.zeros((1, 3)))[0]
    np.testing.assert_allclose(a, [0, 0])
    np.testing.assert_allclose(b, [0, 120], atol=1e-12)
    np.testing.assert_allclose(c, [-121.7, 120], atol=1e-12)
    np.testing.assert_allclose(f, [-128.43, 82], atol=1e-12)


@given(st.tuples(angle, angle, angle), deviations)
def test_forward_is_equations_17_and_18_written_out(q, delta):
    l1, l2, l4, l5 = ARM.link_lengths_mm + delta.lengths_mm
    t1, t12, t123 = np.cumsum(np.array(q) + delta.joints_rad)
    x, y, theta = forward(ARM, np.array([q]), delta)[0]
    assert x == pytest.approx(-l1 * np.sin(t1) - l2 * np.cos(t12) + l4 * np.sin(t123) - l5 * np.cos(t123), abs=1e-9)
    assert y == pytest.approx(l1 * np.cos(t1) - l2 * np.sin(t12) - l4 * np.cos(t123) - l5 * np.sin(t123), abs=1e-9)
    assert theta == pytest.approx(t123 + np.pi)


@given(st.tuples(angle, angle, angle))
def test_b_c_and_f_keep_their_distances_in_every_pose(q):
    a, b, c, f = marker_positions(ARM, np.array([q]))[0]
    assert np.linalg.norm(b - a) == pytest.approx(120.0)
    assert np.linalg.norm(c - b) == pytest.approx(121.7)
    assert np.linalg.norm(f - c) == pytest.approx(np.hypot(38.0, 6.73))


@given(st.floats(-3.0, 3.0), st.floats(-1.5, 1.5), angle, deviations, st.sampled_from(["paper", "other"]))
def test_inverse_gives_the_commands_back_on_its_own_branch(t1, t2, t3, delta, elbow):
    """Branch "paper" has its elbow theta2' within a quarter turn of zero, branch "other" of pi."""
    inside = np.array([t1, t2 if elbow == "paper" else np.pi - t2, t3])
    q = inside - delta.joints_rad
    again = inverse(ARM, forward(ARM, q[None], delta), elbow, delta)[0]
    np.testing.assert_allclose(np.exp(1j * again), np.exp(1j * q), atol=1e-6)


@given(st.floats(0, 2 * np.pi), st.floats(30.0, 230.0), angle, deviations, st.sampled_from(["paper", "other"]))
def test_forward_of_inverse_is_the_pose_on_both_branches(bearing, distance, theta, delta, elbow):
    l1, l2, l4, l5 = ARM.link_lengths_mm + delta.lengths_mm
    assume(abs(l1 - l2) + 1.0 < distance < l1 + l2 - 1.0)
    turn = np.exp(1j * (theta - np.pi))
    tip = distance * np.exp(1j * bearing) - 1j * (l4 - 1j * l5) * turn  # C, then on to F
    pose = np.array([[tip.real, tip.imag, theta]])
    again = forward(ARM, inverse(ARM, pose, elbow, delta), delta)
    np.testing.assert_allclose(again[:, :2], pose[:, :2], atol=1e-9)
    assert np.exp(1j * again[0, 2]) == pytest.approx(np.exp(1j * theta), abs=1e-9)


@pytest.mark.parametrize("elbow", ["paper", "other"])
@pytest.mark.parametrize("name", ["circle_15", "circle_25", "line"])
def test_the_round_trip_closes_on_the_papers_trajectories(name, elbow):
    poses = paper_trajectories()[name]
    assert np.abs(forward(ARM, inverse(ARM, poses, elbow))[:, :2] - poses[:, :2]).max() < 1e-12


def test_the_two_branches_differ():
    poses = circle((-130.0, 40.0), 15.0)
    assert np.abs(inverse(ARM, poses, "paper") - inverse(ARM, poses, "other"))[:, 1].min() > 0.1


def inverse_as_printed(poses):
    """Equations (5) to (9) literally."""
    l1, l2, l4, l5 = ARM.link_lengths_mm
    x, y, theta = poses.T
    Cx = x - l4 * np.sin(theta - np.pi) + l5 * np.cos(theta - np.pi)
    Cy = y + l4 * np.cos(theta - np.pi) + l5 * np.sin(theta - np.pi)
    t2 = -np.arcsin((Cx**2 + Cy**2 - l1**2 - l2**2) / (2 * l1 * l2))
    s2, c2 = np.sin(t2), np.cos(t2)
    t1 = -np.arctan((Cy * l2 * c2 - Cx * (l2 * s2 - l1)) / (Cx * l2 * c2 + Cy * (l2 * s2 - l1)))
    return np.stack([t1, t2, theta - t1 - t2 - np.pi], axis=-1)


@pytest.mark.parametrize(("radius", "coordinate_mm", "distance_mm"), [(15, 48.3, 62.8), (25, 68.5, 92.3)])
def test_equation_8_as_printed_misses_the_papers_circles(radius, coordinate_mm, distance_mm):
    poses = paper_trajectories()[f"circle_{radius}"]
    missed = (forward(ARM, inverse_as_printed(poses)) - poses)[:, :2]
    assert np.abs(missed).max() == pytest.approx(coordinate_mm, abs=0.1)
    assert np.linalg.norm(missed, axis=1).max() == pytest.approx(distance_mm, abs=0.1)


def test_equation_8_is_right_once_its_leading_sign_is_dropped():
    poses = paper_trajectories()["circle_25"]
    np.testing.assert_allclose(-inverse_as_printed(poses)[:, 0], inverse(ARM, poses)[:, 0], atol=1e-12)


def test_with_the_calibrated_deviation_the_built_arm_hits_the_poses():
    poses = paper_trajectories()["line"]
    built = forward(ARM, inverse(ARM, poses, delta=TABLE_4), TABLE_4)
    assert np.abs(built[:, :2] - poses[:, :2]).max() < 1e-11


@pytest.mark.parametrize(
    "pose", [(-400.0, 0.0, np.pi), (-6.23, -38.0, np.pi)], ids=["too far", "C half a millimetre from A"]
)
def test_an_unreachable_pose_is_named_with_the_reach(pose):
    poses = np.array([[-130.0, 40.0, np.pi], pose])
    with pytest.raises(UnreachablePoseError, match=r"pose 1 \(x .* mm, .* the arm reaches 1\.70 to 241\.70 mm"):
        inverse(ARM, poses)


def test_a_pose_that_is_not_finite_is_out_of_reach_too():
    with pytest.raises(UnreachablePoseError, match="pose 0"):
        inverse(ARM, np.array([[np.nan, 40.0, np.pi]]))


def test_the_closed_form_is_for_arms_joined_like_the_papers():
    with pytest.raises(InputError, match="joined like the paper's, found arm 'plain'"):
        inverse(Arm("plain", np.array([50.0]), np.zeros(2)), np.zeros((1, 3)))


@pytest.mark.parametrize(
    "arm", [ARM, Arm("plain", np.array([80.0, 50.0, 30.0, 20.0]), np.zeros(2))], ids=["planar3", "plain"]
)
def test_the_jacobians_are_those_of_central_differences(arm):
    rng = np.random.default_rng(0)
    q = rng.uniform(-np.pi, np.pi, (6, arm.n_joints))
    n_lengths = len(arm.link_lengths_mm)
    delta = Deviation(rng.normal(0, 3, n_lengths), rng.normal(0, 0.1, arm.n_joints))
    by_length, by_joint = forward_jacobian(arm, q, delta)
    step = 1e-5
    for k in range(n_lengths):
        h = np.eye(n_lengths)[k] * step
        ahead, behind = (
            marker_positions(arm, q, Deviation(delta.lengths_mm + s * h, delta.joints_rad)) for s in (1, -1)
        )
        np.testing.assert_allclose(by_length[..., k], (ahead - behind) / (2 * step), atol=1e-8)
    for k in range(arm.n_joints):
        h = np.eye(arm.n_joints)[k] * step
        ahead, behind = (marker_positions(arm, q + s * h, delta) for s in (1, -1))
        np.testing.assert_allclose(by_joint[..., k], (ahead - behind) / (2 * step), atol=1e-6)


def test_each_link_is_a_complex_number_along_its_angle():
    q = np.array([[0.3, -0.4, 0.5]])
    links = complex_links(ARM, TABLE_4) * np.exp(1j * link_angles(ARM, q, TABLE_4))
    f = marker_positions(ARM, q, TABLE_4)[0, -1]
    assert links.sum() == pytest.approx(complex(*f))


@given(st.floats(-100.0, 100.0))
def test_wrapped_angles_point_the_same_way_within_half_a_turn(value):
    wrapped = float(wrap(np.array(value)))
    assert -np.pi < wrapped <= np.pi + 1e-12
    assert np.exp(1j * wrapped) == pytest.approx(np.exp(1j * value), abs=1e-9)


def test_a_chain_of_plain_links_lies_along_x_at_zero():
    arm = Arm("plain", np.array([10.0, 20.0]), np.zeros(2))
    np.testing.assert_allclose(marker_positions(arm, np.zeros((1, 2)))[0], [[0, 0], [10, 0], [30, 0]])
    np.testing.assert_allclose(forward(arm, np.array([[np.pi / 2, 0.0]]))[0], [0, 30, np.pi / 2], atol=1e-12)
