"""Commands corrected by a twin, tried on the bench that the twin stands for."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from armtwin.models.arm import Arm, nominal_arm
from armtwin.models.errors import InputError
from armtwin.models.kinematics import Deviation, forward, inverse
from armtwin.models.reach import reach
from armtwin.models.trajectories import line
from armtwin.models.twin import Twin, TwinEffect, rebuild
from armtwin.models.wanted_path import WantedPath, read_wanted_path
from armtwin.scenarios.twins.correction import correct
from armtwin.sim.physics.simulation import simulate

DEVIATION = Deviation(np.array([1.5, -2.0, 0.4, 0.1]), np.array([0.02, -0.03, 0.01]))
UPRIGHT = replace(nominal_arm(), gravity_m_s2=np.array([0.0, -9.81]))
# There and back again: play has to be taken up both ways.
POINTS = np.concatenate([line((-170.0, 20.0), (-130.0, 70.0), 8, 2.5), line((-130.0, 70.0), (-170.0, 20.0), 8, 2.5)])


def wanted_points(points: np.ndarray, *, oriented: bool = False) -> WantedPath:
    n = len(points)
    places = tuple(f"line {row + 2}" for row in range(n))
    theta = points[:, 2] if oriented else None
    return WantedPath(np.full(n, "path"), np.zeros(n), places, tip_mm=points[:, :2], theta_rad=theta)


@pytest.mark.parametrize(
    ("arm", "effects", "most_mm"),
    [
        (nominal_arm(), (), 0.01),
        (nominal_arm(), (TwinEffect("backlash", 2, None, {"width_rad": 0.02}),), 0.05),
        (nominal_arm(), (TwinEffect("hysteresis", 1, None, {"lag_rad": 0.01, "length_rad": 0.05}),), 0.05),
        (UPRIGHT, (TwinEffect("gravity_sag", None, None, {"compliance1_rad_per_nm": 0.2}),), 0.02),
        (UPRIGHT, (TwinEffect("link_bending", 1, None, {"flexibility_per_nm2": 5.0}),), 0.02),
        (
            nominal_arm(),
            (
                TwinEffect("servo_gain", 1, None, {"gain": 1.05}),
                TwinEffect("servo_nonlinearity", 2, None, {"amplitude_rad": 0.02, "cycles_per_turn": 3.0}),
            ),
            0.02,
        ),
        (nominal_arm(), (TwinEffect("axis_tilt", 2, None, {"tilt_x_rad": 0.05, "tilt_y_rad": -0.03}),), 0.02),
    ],
    ids=lambda value: "+".join(e.effect for e in value) or "geometry" if isinstance(value, tuple) else None,
)
def test_the_corrected_tip_goes_where_it_should_on_the_simulated_bench(
    arm: Arm, effects: tuple[TwinEffect, ...], most_mm: float
) -> None:
    twin = Twin(arm, DEVIATION, np.zeros(3), None, effects)
    found = correct(twin, wanted_points(POINTS))
    bench = simulate(rebuild(twin), found.plan.q_cmd)[:, -1, :2]
    after = np.linalg.norm(bench - POINTS[:, :2], axis=1)
    assert after.max() < most_mm
    assert found.before_mm.max() > 2.0
    np.testing.assert_allclose(found.after_mm, after, atol=1e-6)
    drawn = inverse(arm, POINTS)
    naive = np.linalg.norm(simulate(rebuild(twin), drawn)[:, -1, :2] - POINTS[:, :2], axis=1)
    assert naive.max() > 20 * after.max()


def test_coarse_commands_are_chosen_as_well_as_they_can_be() -> None:
    """A servo that takes whole degrees cannot be corrected; the commands must at least not be worse for the try."""
    twin = Twin(
        nominal_arm(), DEVIATION, np.zeros(3), None, (TwinEffect("quantization", None, None, {"step_rad": 0.0175}),)
    )
    found = correct(twin, wanted_points(POINTS))
    assert np.sqrt(np.mean(found.after_mm**2)) < 0.5 * np.sqrt(np.mean(found.before_mm**2))
    assert found.after_mm.max() > 0.1


def test_joint_poses_are_reached_as_angles() -> None:
    twin = Twin(UPRIGHT, DEVIATION, np.zeros(3), None, (TwinEffect("backlash", 2, None, {"width_rad": 0.02}),))
    q = np.array([[0.1, 0.2, -0.3], [0.4, 0.0, 0.2], [0.1, 0.2, -0.3]])
    found = correct(twin, WantedPath(np.full(3, "p"), np.zeros(3), ("1", "2", "3"), q=q))
    assert found.before_rad is not None
    assert found.after_rad is not None
    assert found.before_rad.min() > 0.02
    assert found.after_rad.max() < 2e-4


def test_what_is_out_of_reach_is_named_and_left_out() -> None:
    twin = Twin(nominal_arm(), DEVIATION, np.zeros(3), None, ())
    points = POINTS[:4].copy()
    points[2, :2] = [-400.0, 0.0]
    found = correct(twin, wanted_points(points))
    assert found.rows.tolist() == [0, 1, 3]
    ((place, missing),) = found.out_of_reach
    assert place == "line 4"
    reach_mm = 121.5 + 119.7 + abs(complex(38.4, 6.83))
    assert missing == pytest.approx(400.0 - reach_mm, abs=0.1)
    with pytest.raises(InputError, match="no point can be reached"):
        correct(twin, wanted_points(points[2:3]))


@pytest.mark.parametrize("n", [1, 2, 4, 6])
def test_an_arm_of_any_number_of_joints_reaches_what_it_can(n: int) -> None:
    arm = Arm("chain", np.full(n, 80.0), np.zeros(2))
    rng = np.random.default_rng(n)
    tips = forward(arm, rng.uniform(-1.0, 1.0, (5, n)))
    found = reach(arm, tips[:, :2])
    assert found.reached.all()
    np.testing.assert_allclose(forward(arm, found.q)[:, :2], tips[:, :2], atol=2e-3)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("x_mm,y_mm,theta1_cmd_rad\n1,2,0\n", "one of both says where to go"),
        ("x_mm\n1\n", "column 'y_mm' is missing"),
        ("x_mm,y_mm,theta_F_rad\n1,2,90\n", "name the column theta_F_deg for degrees"),
        ("x_mm,y_mm\n1,2e5\n", "line 2, column 'y_mm': 200000 is beyond 10000 mm"),
    ],
)
def test_a_plan_that_says_no_path_is_refused_with_the_remedy(tmp_path: Path, text: str, said: str) -> None:
    path = tmp_path / "path.csv"
    path.write_text(text)
    with pytest.raises(InputError, match=said):
        read_wanted_path(path, nominal_arm())


@pytest.mark.parametrize(("highest", "told"), [(2.0, False), (0.25, True)])
def test_commands_beyond_the_drawings_limits_are_told_by_the_joints_name(highest: float, told: bool) -> None:
    limits = np.array([[-2.0, highest], [-2.0, 2.0]])
    arm = Arm("mine", np.array([110.0, 95.0]), np.zeros(2), joints=("shoulder", "elbow"), joint_limits_rad=limits)
    q = np.array([[0.1, 0.4], [0.3, 0.5]])
    wanted = WantedPath(np.full(2, "path"), np.zeros(2), ("line 2", "line 3"), q=q)
    notes = correct(Twin(arm, Deviation.none(arm), np.zeros(3), None, ()), wanted).notes
    said = "joint 1 (shoulder) is commanded beyond its limits, -2 to 0.25 rad, in 1 of 2 rows"
    assert (said in notes) == told
