import numpy as np
import pytest

from armtwin.calib.arm import least_squares
from armtwin.calib.arm.chain import Chain
from armtwin.models.arm import Arm, nominal_arm
from armtwin.models.errors import InputError
from armtwin.models.kinematics import inverse
from armtwin.models.trajectories import paper_trajectories

VARIED = np.random.default_rng(1).uniform(-0.6, 0.6, (40, 3))


def test_of_planar3s_seven_parameters_six_can_be_known_on_every_one_of_the_papers_trajectories():
    chain = Chain(nominal_arm())
    _, slope = chain.coefficients(np.zeros(7))
    for poses in paper_trajectories().values():
        moved = chain.directions(inverse(chain.arm, poses), "f") @ slope  # F relative to A, mm and rad
        values = np.linalg.svd(np.concatenate([moved.real, moved.imag]), compute_uv=False)
        assert values[-1] < 1e-8 * values[-2]


def test_the_open_direction_is_theta3_against_a_rotation_of_l4_and_l5():
    chain = Chain(nominal_arm())
    _, slope = chain.coefficients(np.zeros(7))
    moved = chain.directions(VARIED, "f") @ slope
    direction = np.linalg.svd(np.concatenate([moved.real, moved.imag]))[2][-1]
    l4, l5 = chain.arm.link_lengths_mm[2:]
    expected = np.array([0, 0, -l5, l4, 0, 0, 1.0])
    expected /= np.linalg.norm(expected)
    assert abs(direction @ expected) == pytest.approx(1.0, abs=1e-9)


def test_with_a_b_c_f_the_gauge_is_reported_with_its_convention(simulate):
    found = least_squares.calibrate(simulate(noise_px=0.06))
    assert found.identifiable == 6
    assert len(found.gauge) == 1
    assert "delta_theta3_rad against a rotation of (l4, l5)" in found.gauge[0]
    assert "convention" in found.gauge[0]
    assert found.ties == ()
    assert found.singular_values[-1] < 1e-6 < 1.0 < found.singular_values[-2]


def test_marker_e_breaks_the_gauge(simulate, table_4_deviation):
    found = least_squares.calibrate(simulate(markers="abcef", delta=table_4_deviation, noise_px=0.01))
    assert found.identifiable == 7
    assert found.gauge == ()
    np.testing.assert_allclose(found.deviation.lengths_mm, table_4_deviation.lengths_mm, atol=0.01)
    np.testing.assert_allclose(found.deviation.joints_rad, table_4_deviation.joints_rad, atol=1e-3)


def test_f_alone_at_one_orientation_cannot_tell_the_last_link_from_the_base(simulate, table_4_deviation):
    found = least_squares.calibrate(simulate(markers="f", delta=table_4_deviation, noise_px=0.06))
    assert found.identifiable == 4
    assert "delta_l4_mm, delta_l5_mm, delta_theta3_rad" in found.ties[0]
    np.testing.assert_allclose(found.deviation.lengths_mm[2:], 0.0, atol=1e-3)
    std = dict(zip(found.names, found.std, strict=True))
    assert std["delta_l4_mm"] > 10.0  # no better than the drawing
    assert std["delta_l1_mm"] < 0.1


def test_without_e_and_f_the_last_link_stays_as_drawn(simulate, table_4_deviation):
    found = least_squares.calibrate(simulate(markers="abc", delta=table_4_deviation, noise_px=0.06))
    assert found.identifiable == 4
    assert found.gauge == ()
    assert "delta_theta3_rad" in found.ties[0]


def test_a_joint_that_never_moves_is_reported_when_only_f_is_seen(simulate):
    q = VARIED.copy()
    q[:, 1] = 0.1
    found = least_squares.calibrate(simulate(markers="f", q_cmd=q, noise_px=0.06))
    assert found.identifiable == 4
    assert "delta_l1_mm" in found.ties[0]
    assert "delta_l2_mm" in found.ties[0]


@pytest.mark.parametrize("markers", ["f", "af", "bf"])
def test_collinear_poses_that_leave_parameters_open_are_refused(simulate, markers):
    q = np.array([0.1, 0.2, 0.3]) + np.linspace(0, 0.5, 30)[:, None] * np.array([1.0, 0.0, 0.0])
    with pytest.raises(InputError, match=r"30 poses are collinear.*leave [24] of 6 parameters open .*delta_l2_mm"):
        least_squares.calibrate(simulate(markers=markers, q_cmd=q, noise_px=0.06))


def test_one_pose_repeated_is_refused_when_only_the_tip_is_seen(simulate):
    with pytest.raises(InputError, match="20 poses"):
        least_squares.calibrate(simulate(markers="f", q_cmd=np.full((20, 3), 0.2), noise_px=0.06))


def test_collinear_poses_are_enough_when_every_joint_is_seen(simulate, table_4_deviation):
    q = np.linspace(0, 0.5, 30)[:, None] * np.array([1.0, 1.0, -1.0])
    found = least_squares.calibrate(simulate(q_cmd=q, delta=table_4_deviation, noise_px=0.06))
    assert found.identifiable == 6
    np.testing.assert_allclose(found.deviation.lengths_mm[:2], table_4_deviation.lengths_mm[:2], atol=0.05)


def test_marker_a_alone_says_nothing_about_the_links(simulate):
    with pytest.raises(InputError, match="marker a in these 150 poses says nothing about the arm's links"):
        least_squares.calibrate(simulate(markers="a", noise_px=0.06))


def test_a_plain_chain_has_no_gauge(simulate):
    arm = Arm("plain", np.array([80.0, 60.0]), np.zeros(2))
    q = np.random.default_rng(2).uniform(-1, 1, (20, 2))
    found = least_squares.calibrate(simulate(arm=arm, q_cmd=q, markers="c", noise_px=0.06))
    assert found.identifiable == 4
    assert found.gauge == found.ties == ()
