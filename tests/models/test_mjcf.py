from dataclasses import replace

import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray

from armtwin.models.arm import Arm, nominal_arm
from armtwin.models.kinematics import Deviation, marker_positions
from armtwin.models.mjcf import add_spring, build_arm, heaviest_torque_nm
from armtwin.models.servo import nominal_servo

SERVO = nominal_servo()


def markers_mm(model: mujoco.MjModel, arm: Arm, q: NDArray[np.float64]) -> NDArray[np.float64]:
    data = mujoco.MjData(model)
    data.qpos[: arm.n_joints] = q
    mujoco.mj_kinematics(model, data)
    return np.array([data.site(f"marker_{name}").xpos for name in arm.marker_names]) * 1000.0


def chain(n: int) -> Arm:
    return Arm(f"chain{n}", np.linspace(120.0, 60.0, n), np.array([0.0, -9.81]))


@pytest.mark.parametrize("arm", [nominal_arm(), *(chain(n) for n in range(1, 7))], ids=lambda arm: arm.name)
def test_markers_stand_where_the_kinematics_put_them(arm: Arm) -> None:
    rng = np.random.default_rng(1)
    deviation = Deviation(
        rng.uniform(-5, 5, len(arm.link_lengths_mm)),
        rng.uniform(-0.1, 0.1, arm.n_joints),
    )
    q = rng.uniform(-1, 1, arm.n_joints)
    model = build_arm(arm, SERVO, deviation).compile()
    expected = marker_positions(arm, q[None], deviation)[0]
    np.testing.assert_allclose(markers_mm(model, arm, q)[:, :2], expected, atol=1e-9)


def test_a_link_of_planar3_weighs_what_the_arm_declares() -> None:
    model = build_arm(nominal_arm(), SERVO).compile()
    masses = [float(model.body(name).mass[0]) for name in ("link1", "link2", "link3", "end3")]
    np.testing.assert_allclose(masses, [0.045, 0.045, 0.030, 0.020])


def test_static_torque_of_one_link_is_weight_times_lever() -> None:
    arm = Arm("one", np.array([100.0]), np.array([0.0, -9.81]), np.array([0.2]), 0.05)
    model = build_arm(arm, SERVO).compile()
    data = mujoco.MjData(model)
    data.qpos[0] = np.pi / 3
    mujoco.mj_forward(model, data)
    lever = np.cos(np.pi / 3)
    assert data.qfrc_bias[0] == pytest.approx(9.81 * (0.2 * 0.05 + 0.05 * 0.1) * lever, rel=1e-4)


def test_heaviest_torque_is_that_of_the_stretched_arm() -> None:
    arm = Arm("two", np.array([100.0, 50.0]), np.array([0.0, -9.81]), np.array([0.2, 0.1]), 0.05)
    assert heaviest_torque_nm(arm) == pytest.approx(9.81 * (0.2 * 0.05 + 0.1 * 0.125 + 0.05 * 0.15))
    assert heaviest_torque_nm(arm, 2) == pytest.approx(9.81 * (0.1 * 0.025 + 0.05 * 0.05))


def test_servos_stall_at_the_data_sheets_torque() -> None:
    model = build_arm(nominal_arm(), SERVO).compile()
    np.testing.assert_allclose(model.actuator_forcerange, [[-0.922, 0.922]] * 3)


def test_an_arm_too_heavy_for_the_servo_gets_stronger_ones() -> None:
    arm = replace(nominal_arm(), gravity_m_s2=np.array([0.0, -9.81]), link_masses_kg=np.full(3, 1.0))
    model = build_arm(arm, SERVO).compile()
    assert model.actuator_forcerange[0, 1] > 2.0 * heaviest_torque_nm(arm)


def test_cutting_a_link_changes_neither_its_place_nor_its_weight_nor_its_torque() -> None:
    arm = replace(nominal_arm(), gravity_m_s2=np.array([0.0, -9.81]))
    q = np.array([0.3, -0.4, 0.5])
    whole, cut = build_arm(arm, SERVO).compile(), build_arm(arm, SERVO, bendable=(1, 2, 3)).compile()
    np.testing.assert_allclose(markers_mm(cut, arm, q), markers_mm(whole, arm, q), atol=1e-9)
    torques = []
    for model in (whole, cut):
        data = mujoco.MjData(model)
        data.qpos[:] = q
        mujoco.mj_forward(model, data)
        torques.append(data.qfrc_bias.copy())
    np.testing.assert_allclose(torques[1], torques[0], rtol=1e-4)
    assert whole.body_mass.sum() == pytest.approx(cut.body_mass.sum(), rel=1e-4)


def test_a_spring_shares_the_axis_of_its_servo() -> None:
    spec = build_arm(nominal_arm(), SERVO)
    add_spring(spec, 2, "soft", 0.1)
    model = spec.compile()
    assert model.joint("soft").bodyid[0] == model.joint("joint2").bodyid[0]
    np.testing.assert_allclose(model.joint("soft").axis, model.joint("joint2").axis)
    assert model.joint("soft").stiffness[0] == pytest.approx(10.0)
