"""What each effect does to a moving arm when MuJoCo makes it."""

import numpy as np
import pytest

from armtwin.models.catalogue.motion_effect import motion_catalogue
from armtwin.models.catalogue.motion_injection import inject_in_motion
from armtwin.models.catalogue.site import Site
from armtwin.models.errors import InputError
from armtwin.models.motion_world import ideal_motion_world
from tests.sim.motion.worlds import moved, run, steps, swing, upright

# Rows of `swing` in the middle of its way down (0.5 rad/s), and of `steps` at the end of each hold.
DOWN = 150
HOLDS = [199, 399, 599, 799]
ON_THE_WAY = 0.5
MRAD = 1e-3


def test_every_effect_of_a_moving_arm_can_be_made() -> None:
    assert [name for name, effect in motion_catalogue().items() if effect.injector is None] == []


def test_latency_shifts_the_answer_by_its_delay() -> None:
    assert moved("latency", swing(3), delay_s=0.034)[DOWN] == pytest.approx([0, ON_THE_WAY * 0.034, 0], abs=0.4 * MRAD)


def test_a_lag_follows_an_even_motion_by_its_time() -> None:
    late = moved("servo_lag", swing(3), time_constant_s=0.08)[DOWN]
    assert late == pytest.approx([0, ON_THE_WAY * 0.060, 0], abs=0.4 * MRAD)


def test_a_speed_limit_takes_its_time_for_a_step() -> None:
    motion = steps(3)
    world = inject_in_motion(ideal_motion_world(upright()), "speed_limit", {"speed_rad_s": 1.0}, Site(joint=2))
    assert run(world, motion)[220, 1] == pytest.approx(0.2, abs=1 * MRAD)


def test_a_motor_of_little_torque_is_slower_against_gravity_than_with_it() -> None:
    motion = steps(3, (0.0, 0.8, 0.0))
    world = inject_in_motion(ideal_motion_world(upright()), "torque_limit", {"torque_nm": 0.4}, Site(joint=1))
    angles = run(world, motion)[:, 0]
    up, down = angles[206], 0.8 - angles[406]
    assert up < 0.9 * down


def test_dry_friction_lags_by_its_size_either_way_and_stands_still_within_it() -> None:
    assert moved("friction", swing(3), coulomb_rad=0.012)[[DOWN, 350], 1] == pytest.approx(
        [0.012, -0.012], abs=0.1 * MRAD
    )
    motion = steps(3, (0.0, 0.010, 0.0, 0.010))
    world = inject_in_motion(ideal_motion_world(upright()), "friction", {"coulomb_rad": 0.012}, Site(joint=2))
    assert np.ptp(run(world, motion)[:, 1]) < 0.1 * MRAD


def test_friction_is_larger_at_standstill_where_it_is_said_to_be() -> None:
    stuck = {"coulomb_rad": 0.004, "stribeck_rad": 0.02, "stribeck_speed_rad_s": 0.05}
    world = inject_in_motion(ideal_motion_world(upright()), "friction", stuck, Site(joint=2))
    assert np.ptp(run(world, steps(3, (0.0, 0.02, 0.0)))[:, 1]) < 0.1 * MRAD
    assert moved("friction", swing(3), **stuck)[DOWN, 1] == pytest.approx(0.004, abs=0.2 * MRAD)


def test_friction_may_grow_with_the_load() -> None:
    lag = moved("friction", swing(3), joint=1, load_share=0.5)[:, 0]
    near_level, swung_up = np.abs(lag[100]), np.abs(lag[10])
    assert near_level > 1.02 * swung_up > 0.0


def test_viscous_friction_is_a_lag() -> None:
    assert moved("friction", swing(3), viscous_s=0.02)[DOWN, 1] == pytest.approx(ON_THE_WAY * 0.02, abs=0.3 * MRAD)


def test_a_heavy_rotor_overshoots() -> None:
    motion = steps(3, (0.0, 0.1))
    world = inject_in_motion(ideal_motion_world(upright()), "inertia", {"armature_kg_m2": 0.05}, Site(joint=2))
    damping = 0.020 / 2.0 * (50.0 / 0.05) ** 0.5
    overshoot = np.exp(-np.pi * damping / np.sqrt(1 - damping**2))
    assert run(world, motion)[:, 1].max() == pytest.approx(0.1 * (1 + overshoot), rel=0.01)


def test_from_a_moment_on_all_joints_hear_later() -> None:
    late = moved("sampling", swing(3, 8.0), joint=None, from_s=4.0, delay_s=0.05)
    assert np.abs(late[:400]).max() == 0.0
    assert late[550] == pytest.approx(np.full(3, 0.025), abs=0.2 * MRAD)


def test_from_a_moment_on_readings_repeat() -> None:
    world = inject_in_motion(ideal_motion_world(upright()), "sampling", {"from_s": 2.0, "held_rows": 3})
    moves = np.abs(np.diff(run(world, swing(3))[250:350, 1])) > 0
    assert np.flatnonzero(moves)[1:] - np.flatnonzero(moves)[:-1] == pytest.approx(3)


def test_a_stop_holds_the_arm_on_its_side() -> None:
    world = inject_in_motion(ideal_motion_world(upright()), "contact", {"stop_rad": 0.2}, Site(joint=2))
    angles = run(world, steps(3))[:, 1]
    assert angles[HOLDS] == pytest.approx([0.0, 0.2, 0.0, 0.05], abs=0.1 * MRAD)
    assert angles.max() < 0.202


def test_play_comes_to_half_its_width_either_way() -> None:
    assert moved("backlash", swing(3), width_rad=0.02)[[DOWN, 350], 1] == pytest.approx([0.01, -0.01], abs=0.2 * MRAD)


def test_a_bristly_drive_lags_by_its_lag_and_less_just_after_a_reversal() -> None:
    lag = moved("hysteresis", swing(3), lag_rad=0.01, length_rad=0.05)[:, 1]
    assert lag[[DOWN, 350]] == pytest.approx([0.01, -0.01], abs=0.1 * MRAD)
    assert abs(lag[205]) < 0.009


def test_small_changes_are_ignored_within_the_dead_band() -> None:
    world = inject_in_motion(ideal_motion_world(upright()), "dead_band", {"threshold_rad": 0.02}, Site(joint=2))
    assert np.ptp(run(world, steps(3, (0.0, 0.015, 0.03)))[:390, 1]) < 1e-5


def test_commands_land_on_counts() -> None:
    world = inject_in_motion(
        ideal_motion_world(upright()), "quantization", {"step_rad": 0.02, "origin_rad": 0.005}, Site(joint=2)
    )
    assert run(world, steps(3, (0.004, 0.012)))[[199, 399], 1] == pytest.approx([0.005, 0.005], abs=0.1 * MRAD)


def test_a_loop_without_its_integral_part_gives_under_gravity() -> None:
    down = moved("gravity_sag", steps(3), joint=1, compliance_rad_per_nm=0.05)[HOLDS[0], 0]
    twice = moved("gravity_sag", steps(3), joint=1, compliance_rad_per_nm=0.1)[HOLDS[0], 0]
    assert down < -5 * MRAD
    assert twice == pytest.approx(2 * down, rel=0.02)


def test_a_mass_nobody_declared_bends_the_arm_from_its_moment_on() -> None:
    sunk = moved("payload", steps(3), joint=None, mass_kg=0.1, from_s=1.0)
    assert np.abs(sunk[:100]).max() < 1e-9
    arm_m = 0.120 + 0.090 + 0.060
    assert sunk[HOLDS[0], 0] == pytest.approx(-0.05 * 0.1 * 9.81 * arm_m, rel=0.05)


def test_a_gain_scales_and_a_curve_bends() -> None:
    assert moved("servo_gain", steps(3), gain=1.05)[HOLDS[1], 1] == pytest.approx(0.025, abs=0.1 * MRAD)
    bent = moved("servo_nonlinearity", steps(3), curvature_per_rad=0.1)[HOLDS[1], 1]
    assert bent == pytest.approx(0.5 * 0.1 * 0.5**2, abs=0.1 * MRAD)
    rippled = moved("servo_nonlinearity", steps(3), sine_rad=0.006, cosine_rad=0.008, cycles_per_turn=3.0)[HOLDS[1], 1]
    assert rippled == pytest.approx(0.006 * np.sin(1.5) + 0.008 * np.cos(1.5), abs=0.3 * MRAD)


def test_a_zero_drifts_slips_and_creeps() -> None:
    drift = moved("thermal_drift", steps(3), drift_rad=0.02, time_constant_s=2.0)[HOLDS, 1]
    assert drift[0] < drift[1] < drift[3] < 0.02
    slip = moved("joint_slip", steps(3), jump_rad=0.02, from_s=3.0)
    assert slip[[299, 310], 1] == pytest.approx([0.0, 0.02], abs=0.1 * MRAD)
    creep = moved("thermal_drift", steps(3), creep_rad_per_s=1e-3)[HOLDS[3], 1]
    assert creep == pytest.approx(8 * MRAD, abs=0.1 * MRAD)


def test_lost_commands_leave_a_joint_where_it_was() -> None:
    late = moved("missed_command", steps(3, (0.0, 0.2)), samples=[200, 201, 202])
    assert late[203, 1] < -0.1
    assert np.abs(late[:, [0, 2]]).max() < 0.4 * MRAD


def test_garbled_readings_are_as_many_and_as_far_off_as_stated() -> None:
    off = np.abs(moved("outliers", steps(3), rate=0.1, size_rad=0.1)[:, 1])
    assert 0.05 < np.mean(off > 0) < 0.15
    assert off[off > 0].min() >= 0.05


def test_an_effect_of_a_joint_sits_at_all_joints_where_none_is_named() -> None:
    late = moved("latency", swing(3), joint=None, delay_s=0.02)[DOWN]
    assert late == pytest.approx(np.full(3, 0.01), abs=0.4 * MRAD)


def test_what_cannot_be_is_refused_in_one_line() -> None:
    world = ideal_motion_world(upright())
    for name, parameters, joint, message in (
        ("latency", {"delay": 0.1}, 1, "latency: unknown key 'delay'"),
        ("latency", {"delay_s": -1.0}, 1, "delay_s: found -1"),
        ("latency", {"delay_s": 0.1}, 4, "joint: found 4"),
        ("latncy", {"delay_s": 0.1}, 1, "no effect 'latncy'"),
    ):
        with pytest.raises(InputError, match=message):
            inject_in_motion(world, name, parameters, Site(joint=joint))


def test_dry_friction_takes_nothing_from_the_top_speed() -> None:
    motion = steps(3, (0.0, 1.2))
    world = ideal_motion_world(upright())
    rubbing = inject_in_motion(world, "friction", {"coulomb_rad": 0.02}, Site(joint=2))
    bristly = inject_in_motion(world, "hysteresis", {"lag_rad": 0.02, "length_rad": 0.08}, Site(joint=2))
    speeds = [np.diff(run(one, motion)[212:214, 1])[0] * 100.0 for one in (world, rubbing, bristly)]
    assert speeds == pytest.approx([6.16, 6.16, 6.16], abs=0.02)
