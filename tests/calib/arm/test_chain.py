import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from armtwin.calib.arm.chain import Chain
from armtwin.models.arm import Arm, nominal_arm
from armtwin.models.kinematics import Deviation, forward, marker_positions

PLAIN = Arm("plain", np.array([80.0, 60.0, 40.0, 20.0]), np.zeros(2))
small = st.floats(-0.3, 0.3)


def parameters_of(chain: Chain, seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return rng.normal(0.0, 1.0, len(chain.names)) * np.where([n.endswith("_mm") for n in chain.names], 5.0, 0.2)


@pytest.mark.parametrize("arm", [nominal_arm(), PLAIN], ids=["planar3", "plain chain"])
def test_the_complex_form_puts_every_marker_where_the_kinematics_put_it(arm):
    chain = Chain(arm)
    x = parameters_of(chain, 1)
    q = np.random.default_rng(2).uniform(-np.pi, np.pi, (20, arm.n_joints))
    c, _ = chain.coefficients(x)
    expected = marker_positions(arm, q, chain.deviation(x))
    for index, name in enumerate(arm.marker_names):
        w = chain.directions(q, name) @ c
        np.testing.assert_allclose(np.stack([w.real, w.imag], -1), expected[:, index], atol=1e-11)


def test_marker_e_stands_l4_from_c_and_l5_from_f_with_a_right_angle():
    chain = Chain(nominal_arm())
    x = parameters_of(chain, 3)
    q = np.random.default_rng(4).uniform(-1, 1, (10, 3))
    coefficients, _ = chain.coefficients(x)
    c, e, f = (chain.directions(q, name) @ coefficients for name in "cef")
    np.testing.assert_allclose(np.abs(e - c), 38.0 + x[2])
    np.testing.assert_allclose((f - e) / (e - c), -1j * (6.73 + x[3]) / (38.0 + x[2]))


@pytest.mark.parametrize("arm", [nominal_arm(), PLAIN], ids=["planar3", "plain chain"])
def test_the_derivative_of_the_coefficients_is_that_of_central_differences(arm):
    chain = Chain(arm)
    x = parameters_of(chain, 5)
    _, slope = chain.coefficients(x)
    step = 1e-6
    for k in range(len(x)):
        h = np.eye(len(x))[k] * step
        difference = (chain.coefficients(x + h)[0] - chain.coefficients(x - h)[0]) / (2 * step)
        np.testing.assert_allclose(slope[:, k], difference, atol=1e-7)


@given(st.tuples(small, small, small), st.tuples(small, small, small, small))
def test_bringing_a_deviation_into_the_convention_moves_f_by_nothing_and_keeps_the_drawn_angle(joints, lengths):
    arm = nominal_arm()
    chain = Chain(arm)
    delta = Deviation(10.0 * np.array(lengths), np.array(joints))
    same = chain.in_convention(delta)
    q = np.random.default_rng(0).uniform(-np.pi, np.pi, (10, 3))
    np.testing.assert_allclose(forward(arm, q, same)[:, :2], forward(arm, q, delta)[:, :2], atol=1e-10)
    l4, l5 = arm.link_lengths_mm[2:] + same.lengths_mm[2:]
    assert l5 / l4 == pytest.approx(6.73 / 38.0)


def test_table_4s_deviation_is_not_in_the_convention_and_its_turn_goes_to_theta3(table_4_deviation):
    chain = Chain(nominal_arm())
    same = chain.in_convention(table_4_deviation)
    np.testing.assert_array_equal(same.lengths_mm[:2], table_4_deviation.lengths_mm[:2])
    shape = np.arctan2(6.73 + 1.0208, 38.0 - 0.7074) - np.arctan2(6.73, 38.0)
    assert same.joints_rad[2] == pytest.approx(table_4_deviation.joints_rad[2] - shape)


def test_names_follow_the_paper_for_planar3_and_count_links_otherwise():
    assert Chain(nominal_arm()).names[:4] == ("delta_l1_mm", "delta_l2_mm", "delta_l4_mm", "delta_l5_mm")
    assert Chain(PLAIN).names[:4] == ("delta_l1_mm", "delta_l2_mm", "delta_l3_mm", "delta_l4_mm")
    assert Chain(PLAIN).names[-1] == "delta_theta4_rad"
