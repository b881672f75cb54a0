"""A bending link is a slender cantilever."""

from dataclasses import replace

import numpy as np
import pytest

from armtwin.models.catalogue.context import Context
from tests.support.contexts import context_of, turned

GRAVITY = 9.81
# Small enough that the bent link lies as level as the straight one.
FLEXIBILITY = 2e-3


def level(link_kg: float, tip_kg: float) -> Context:
    """Return links 1 and 2 pointing right in a row, the last one folded up to nothing, and a load at the end."""
    context = context_of(np.array([[-np.pi / 2, -np.pi / 2, 0.0]]))
    arm = replace(context.arm, link_masses_kg=np.array([0.0, link_kg, 0.0]), tip_mass_kg=tip_kg)
    return replace(context, arm=arm, links=np.array([120.0, 100.0, 1e-9], dtype=complex))


def test_an_end_load_turns_the_chord_by_force_times_length_squared_over_3_ei() -> None:
    context = level(link_kg=0.0, tip_kg=0.5)
    bent = turned("link_bending", context, [FLEXIBILITY], joint=2) - context.q_cmd
    assert bent[0, 1] == pytest.approx(-FLEXIBILITY * 0.5 * GRAVITY * 0.1**2 / 3)


def test_and_the_end_s_slope_by_force_times_length_squared_over_2_ei() -> None:
    context = level(link_kg=0.0, tip_kg=0.5)
    bent = turned("link_bending", context, [FLEXIBILITY], joint=2) - context.q_cmd
    assert bent[0, 1] + bent[0, 2] == pytest.approx(-FLEXIBILITY * 0.5 * GRAVITY * 0.1**2 / 2)


def test_its_own_weight_turns_the_chord_by_weight_times_length_squared_over_8_ei() -> None:
    context = level(link_kg=0.4, tip_kg=0.0)
    bent = turned("link_bending", context, [FLEXIBILITY], joint=2) - context.q_cmd
    assert bent[0, 1] == pytest.approx(-FLEXIBILITY * 0.4 * GRAVITY * 0.1**2 / 8)


def test_a_stiff_link_stays_straight_and_the_links_before_it_too() -> None:
    context = context_of()
    assert not (turned("link_bending", context, [0.0], joint=2) - context.q_cmd).any()
    assert not (turned("link_bending", context, [5.0], joint=2) - context.q_cmd)[:, 0].any()
