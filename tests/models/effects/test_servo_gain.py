"""A wrong gain: the servo turns a fraction of what is commanded."""

import numpy as np

from armtwin.models.world import Command
from tests.support.contexts import context_of, turned
from tests.support.worlds import flat_world, with_effect


def test_the_joint_turns_gain_times_its_command_and_the_others_theirs() -> None:
    context = context_of()
    out = turned("servo_gain", context, [1.1], joint=2)
    np.testing.assert_allclose(out, context.q_cmd * [1.0, 1.1, 1.0])


def test_a_potentiometer_of_another_span_makes_the_same_gain() -> None:
    context = context_of()
    board = with_effect(flat_world(), "servo_gain", {"gain": 0.93}, joint=3).electronics[0]()
    made = np.array([board(Command(row, 0.0, q)) for row, q in enumerate(context.q_cmd)])
    np.testing.assert_allclose(made, turned("servo_gain", context, [0.93], joint=3))
