import numpy as np
import pytest

from armtwin.calib.arm import algorithm_1, least_squares
from armtwin.calib.arm.chain import Chain
from armtwin.models.arm import Arm, nominal_arm
from armtwin.models.errors import InputError
from armtwin.models.kinematics import Deviation, forward, inverse
from armtwin.models.trajectories import paper_trajectories

CHAIN = Chain(nominal_arm())
OTHER_START = (0.0,) * 7


def descend(recording, trajectories=("circle_15", "circle_25"), **options):
    rows = np.flatnonzero(np.isin(recording.trajectory, trajectories))
    measured, seen, _ = algorithm_1.measured_tip(recording, rows)
    return algorithm_1.descend(CHAIN, recording.q_cmd[seen], measured, **options)


def test_it_starts_at_the_papers_vector():
    assert algorithm_1.X0 == (5, 5, 1, 1, 5, 5, 5)


def test_f_is_measured_relative_to_a_in_the_robot_frame(simulate, table_4_deviation):
    recording = simulate(delta=table_4_deviation)
    measured, _, base = algorithm_1.measured_tip(recording, np.arange(150))
    np.testing.assert_allclose(measured, forward(recording.arm, recording.q_cmd, table_4_deviation)[:, :2], atol=1e-9)
    np.testing.assert_allclose(base, [-35.0, -20.0, -80.87], atol=1e-9)


def test_poses_without_a_or_f_are_skipped(simulate):
    recording = simulate()
    recording.markers_px["a"][:10] = np.nan
    recording.markers_px["f"][5:20] = np.nan
    measured, rows, _ = algorithm_1.measured_tip(recording, np.arange(150))
    assert len(measured) == 130
    assert rows[0] == 20


def test_the_errors_and_their_jacobian_are_equations_19_and_22():
    rng = np.random.default_rng(0)
    q = rng.uniform(-0.5, 0.5, (12, 3))
    measured = forward(CHAIN.arm, q)[:, :2] + rng.normal(0, 2, (12, 2))
    x = np.array([5.0, 5.0, 1.0, 1.0, 5.0, 5.0, 5.0])
    directions = CHAIN.directions(q, "f")
    E, J = algorithm_1._errors(CHAIN, directions, measured, x)
    l1, l2, l4, l5 = CHAIN.arm.link_lengths_mm + x[:4]
    t1, t12, t123 = np.cumsum(q + np.radians(x[4:]), axis=1).T
    Fx = -l1 * np.sin(t1) - l2 * np.cos(t12) + l4 * np.sin(t123) - l5 * np.cos(t123)
    Fy = l1 * np.cos(t1) - l2 * np.sin(t12) - l4 * np.cos(t123) - l5 * np.sin(t123)
    np.testing.assert_allclose(E, np.hypot(measured[:, 0] - Fx, measured[:, 1] - Fy))
    for k in range(7):
        h = np.eye(7)[k] * 1e-5
        ahead, behind = (algorithm_1._errors(CHAIN, directions, measured, x + s * h)[0] for s in (1, -1))
        np.testing.assert_allclose(J[:, k], (ahead - behind) / 2e-5, atol=1e-6)


def test_one_step_is_equation_23(simulate, table_4_deviation):
    recording = simulate(delta=table_4_deviation)
    zero, one = (descend(recording, max_steps=steps) for steps in (0, 1))
    measured, _, _ = algorithm_1.measured_tip(recording, np.arange(100))
    E, J = algorithm_1._errors(CHAIN, CHAIN.directions(recording.q_cmd[:100], "f"), measured, np.array(algorithm_1.X0))
    np.testing.assert_array_equal(zero.x, algorithm_1.X0)
    np.testing.assert_allclose(one.x, np.array(algorithm_1.X0) - one.alpha * E @ J)


def test_the_sum_of_squared_errors_falls_at_every_step(simulate, table_4_deviation):
    recording = simulate(delta=table_4_deviation, noise_px=0.06)
    sums = []
    for steps in range(0, 60, 3):
        x = descend(recording, max_steps=steps, error_max_mm=0.0).x
        tip = forward(CHAIN.arm, recording.q_cmd[:100], algorithm_1.deviation_of(x))[:, :2]
        measured, _, _ = algorithm_1.measured_tip(recording, np.arange(100))
        sums.append(((tip - measured) ** 2).sum())
    assert (np.diff(sums) < 0).all()


def test_it_stops_when_the_mean_error_is_below_error_max(simulate, table_4_deviation):
    descent = descend(simulate(delta=table_4_deviation), error_max_mm=0.25)
    assert descent.errors_mm[-1] < 0.25 <= descent.errors_mm[-2]
    assert "errorMax" in descent.stopped


def test_it_stops_at_the_bound_when_error_max_cannot_be_reached(simulate, table_4_deviation):
    descent = descend(simulate(delta=table_4_deviation, noise_px=5.0), max_steps=50)
    assert len(descent.errors_mm) == 51
    assert "bound of 50 steps" in descent.stopped


def test_table_4s_separate_l4_l5_theta3_come_from_the_starting_vector(simulate, table_4_deviation):
    """An arm turned far along the gauge moves F as Table 4's does; from X0 the algorithm reports Table 4 for it."""
    gauge_turned = CHAIN.in_convention(table_4_deviation)
    assert abs(np.degrees(gauge_turned.joints_rad[2] - table_4_deviation.joints_rad[2])) > 1.5
    x = descend(simulate(delta=gauge_turned), error_max_mm=0.0).x
    np.testing.assert_allclose(x[[2, 3]], table_4_deviation.lengths_mm[[2, 3]], atol=0.1)
    assert x[6] == pytest.approx(np.degrees(table_4_deviation.joints_rad[2]), abs=0.05)


def test_another_start_ends_elsewhere_with_the_same_motion_of_f_while_least_squares_has_no_start(
    simulate, table_4_deviation
):
    recording = simulate(delta=table_4_deviation, noise_px=0.06)
    paper = descend(recording, ["circle_25"], error_max_mm=0.0, max_steps=10_000).x
    other = descend(recording, ["circle_25"], error_max_mm=0.0, max_steps=10_000, start=OTHER_START).x
    assert np.abs(paper - other)[[3, 6]].min() > 1.0  # mm of l5, degrees of theta3
    tips = [forward(CHAIN.arm, recording.q_cmd[:50], algorithm_1.deviation_of(x))[:, :2] for x in (paper, other)]
    assert np.abs(tips[0] - tips[1]).max() < 0.01
    one, same = (CHAIN.in_convention(algorithm_1.deviation_of(x)) for x in (paper, other))
    np.testing.assert_allclose(one.lengths_mm, same.lengths_mm, atol=0.02)
    found = least_squares.calibrate(recording, ["circle_25"])
    assert found.deviation.lengths_mm[3] / found.deviation.lengths_mm[2] == pytest.approx(6.73 / 38.0)


def test_least_squares_finds_the_same_whatever_gauge_the_arm_was_built_in(simulate, table_4_deviation):
    found = least_squares.calibrate(simulate(delta=table_4_deviation, noise_px=0.06, seed=3))
    turned = least_squares.calibrate(simulate(delta=CHAIN.in_convention(table_4_deviation), noise_px=0.06, seed=3))
    np.testing.assert_allclose(found.values, turned.values, atol=1e-7)


def test_table_4s_own_values_predict_a_mean_error_of_2_0_mm_on_the_validation_line(table_4_deviation):
    line = paper_trajectories()["line"]
    built = forward(CHAIN.arm, inverse(CHAIN.arm, line), table_4_deviation)
    assert np.linalg.norm((built - line)[:, :2], axis=1).mean() == pytest.approx(2.0, abs=0.05)


def test_calibrate_reports_the_gauge_and_why_it_stopped(simulate, table_4_deviation):
    found = algorithm_1.calibrate(simulate(delta=table_4_deviation, held_out=("line",)))
    assert found.method == "algorithm-1"
    assert found.n_poses == 100
    assert "starting vector" in found.gauge[0]
    assert "errorMax" in found.ties[0]
    assert found.rms_mm < 0.5
    assert np.isnan(found.std).all()


def test_it_refuses_another_arm_missing_markers_and_too_few_poses(simulate):
    arm = Arm("plain", np.array([80.0, 60.0]), np.zeros(2))
    with pytest.raises(InputError, match="Algorithm 1 is for arm planar3, found 'plain'"):
        algorithm_1.calibrate(simulate(arm=arm, q_cmd=np.zeros((9, 2)), markers="abc"))
    with pytest.raises(InputError, match="needs the markers a and f"):
        algorithm_1.calibrate(simulate(markers="bf"))
    few = simulate()
    few.markers_px["f"][3:] = np.nan
    with pytest.raises(InputError, match=r"3 poses .* measure 2 more"):
        algorithm_1.calibrate(few)


def test_a_measured_point_exactly_on_the_model_gives_no_gradient():
    q = np.zeros((6, 3))
    measured = forward(CHAIN.arm, q, Deviation(np.array([5.0, 5, 1, 1]), np.radians([5.0, 5, 5])))[:, :2]
    _, J = algorithm_1._errors(CHAIN, CHAIN.directions(q, "f"), measured, np.array(algorithm_1.X0))
    assert np.isfinite(J).all()
