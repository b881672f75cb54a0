"""What gives under weight: joints, links, and what hangs at the tip."""

import mujoco
import numpy as np
import pytest

from armtwin.models.kinematics import Deviation
from armtwin.models.mjcf import build_arm
from armtwin.models.world import World
from armtwin.sim.physics.simulation import simulate
from tests.support.worlds import errors_rad, flat_world, scattered, upright_world, with_effect


def torques_nm(world: World, q: np.ndarray) -> np.ndarray:
    """Static torques about the joints of the rigid arm at (N, n) angles, by MuJoCo."""
    model = build_arm(world.arm, world.servo, world.deviation).compile()
    data = mujoco.MjData(model)
    out = []
    for angles in q:
        data.qpos[:] = angles
        mujoco.mj_forward(model, data)
        out.append(data.qfrc_bias.copy())
    return np.array(out)


def test_a_joint_sags_by_its_compliance_times_the_torque() -> None:
    world = with_effect(upright_world(), "gravity_sag", {"compliance2_rad_per_nm": 0.02})
    q = scattered(6)
    error = errors_rad(world, q)
    np.testing.assert_allclose(error[:, 1], -0.02 * torques_nm(world, q)[:, 1], atol=3e-5)
    assert np.abs(error[:, [0, 2]]).max() < 2e-5


def test_no_joint_sags_in_an_arm_that_lies_flat() -> None:
    world = with_effect(flat_world(), "gravity_sag", {"compliance2_rad_per_nm": 0.1})
    assert np.abs(errors_rad(world, scattered(4))).max() < 2e-5


def test_sag_remembers_nothing() -> None:
    world = with_effect(upright_world(), "gravity_sag", {"compliance1_rad_per_nm": 0.1, "compliance3_rad_per_nm": 0.1})
    q = scattered(5)
    np.testing.assert_allclose(errors_rad(world, q), errors_rad(world, q[::-1])[::-1], atol=3e-5)


def test_a_bent_link_deflects_as_a_cantilever() -> None:
    # Link 2 level: everything beyond it and its own weight bend it; Euler-Bernoulli, handbook values.
    flexibility = 0.5
    world = with_effect(upright_world(), "link_bending", {"flexibility_per_nm2": flexibility}, joint=2)
    q = np.zeros((1, 3))
    bent, straight = simulate(world, q)[0], simulate(upright_world(), q)[0]
    c = world.arm.known_markers.index("c")
    length, g = 0.1217, 9.81
    force, weight_per_m = (0.030 + 0.020) * g, 0.045 * g / length
    moment = -torques_nm(upright_world(), q)[0, 2]
    down = force * length**3 / 3 + moment * length**2 / 2 + weight_per_m * length**4 / 8
    assert straight[c, 1] - bent[c, 1] == pytest.approx(1000 * flexibility * down, rel=0.01)
    slope = flexibility * (force * length**2 / 2 + moment * length + weight_per_m * length**3 / 6)
    tip = bent[-1] - bent[c]
    before = straight[-1] - straight[c]
    turned = np.arctan2(tip[1], tip[0]) - np.arctan2(before[1], before[0])
    assert turned == pytest.approx(slope, rel=0.02)


def test_a_mass_at_the_tip_shows_from_its_sample_on() -> None:
    soft = {"compliance1_rad_per_nm": 0.03, "compliance2_rad_per_nm": 0.03, "compliance3_rad_per_nm": 0.03}
    q = np.tile([0.1, 0.1, -0.2], (4, 1))
    loaded = with_effect(upright_world(), "payload", {"mass_kg": 0.1, "from_sample": 2, **soft})
    error = errors_rad(loaded, q)
    np.testing.assert_allclose(error[1], error[0], atol=2e-5)
    np.testing.assert_allclose(error[3], error[2], atol=2e-5)
    lever_m = 0.001 * np.abs(
        simulate(upright_world(), q[:1])[0, [0, 1, 2], 0] - simulate(upright_world(), q[:1])[0, 4, 0]
    )
    np.testing.assert_allclose(np.abs(error[2] - error[0]), 0.03 * 0.1 * 9.81 * lever_m, rtol=0.03, atol=2e-5)


def test_without_springs_of_its_own_a_payload_bends_the_servos_gears() -> None:
    world = upright_world(Deviation.none(upright_world().arm))
    q = np.tile([0.1, 0.1, -0.2], (2, 1))
    loaded = with_effect(world, "payload", {"mass_kg": 0.1, "from_sample": 1})
    error = errors_rad(loaded, q)
    assert np.abs(error[1] - error[0]).max() > 0.003
