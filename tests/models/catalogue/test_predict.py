"""The extended twin: effects act in the order of their stages."""

import numpy as np
import pytest

from armtwin.models.catalogue.points import Geometry
from armtwin.models.catalogue.predict import joint_angles, marker_points, ordered
from armtwin.models.catalogue.registry import Stage
from armtwin.models.kinematics import Deviation, complex_links, marker_positions
from tests.support.contexts import active, context_of, drawn


def test_without_effects_the_links_stand_at_their_commands() -> None:
    context = context_of()
    np.testing.assert_array_equal(joint_angles(context, ()), context.q_cmd)


def test_points_are_those_of_the_kinematics_with_the_same_lengths_and_zeros() -> None:
    context = context_of()
    built = Deviation(np.array([2.0, -3.0, 0.5, 0.2]), np.array([0.02, -0.01, 0.03]))
    links = complex_links(context.arm, built) * np.exp(1j * np.cumsum(built.joints_rad))
    points = marker_points(context, Geometry(np.array([5.0, -7.0]), links), context.q_cmd)
    expected = marker_positions(context.arm, context.q_cmd, built) + np.array([5.0, -7.0])
    np.testing.assert_allclose(points[..., :2], expected, atol=1e-9)
    assert not points[..., 2].any()


def test_marker_e_is_the_corner_of_the_last_link() -> None:
    context = context_of(markers=("a", "b", "c", "e", "f"))
    points = marker_points(context, drawn(context), context.q_cmd)[..., :2] @ [1.0, 1j]
    l4, l5 = context.arm.link_lengths_mm[2:]
    np.testing.assert_allclose(np.abs(points[:, 3] - points[:, 2]), l4)
    np.testing.assert_allclose(np.abs(points[:, 4] - points[:, 3]), l5)


def test_commands_are_rounded_before_the_servo_multiplies_them_and_play_comes_last() -> None:
    effects = [active("backlash", [0.1], joint=1), active("servo_gain", [1.5], joint=1), active("quantization", [0.1])]
    assert [one.effect.stage for one in ordered(effects)] == [Stage.COMMAND, Stage.SERVO, Stage.JOINT]
    q = np.zeros((2, 3))
    q[:, 0] = [0.0, 0.26]
    # 0.26 is sent as 0.3, turned as 0.45 and reached but for half the gap.
    assert joint_angles(context_of(q), effects)[1, 0] == pytest.approx(0.3 * 1.5 - 0.05)


def test_two_effects_of_different_joints_add_up() -> None:
    context = context_of()
    first, second = active("servo_gain", [1.1], joint=1), active("joint_slip", [0.05, 9.0], joint=3)
    alone = [joint_angles(context, [one]) - context.q_cmd for one in (first, second)]
    np.testing.assert_allclose(joint_angles(context, [first, second]) - context.q_cmd, sum(alone))


def test_an_effect_is_labelled_with_its_place() -> None:
    assert active("backlash", [0.1], joint=2).label == "backlash (joint 2)"
    assert active("marker_offset", [1.0, 0.0], marker="b").label == "marker_offset (marker B)"
    assert active("gravity_sag", [0.1]).label == "gravity_sag (whole arm)"
    assert active("camera_tilt", [0.1]).label == "camera_tilt (camera)"
