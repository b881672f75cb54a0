"""What a model term may know."""

import numpy as np
import pytest

from tests.support.contexts import context_of

GRAVITY = 9.81


def potential_j(context: object, q: np.ndarray, links_kg: np.ndarray, tip_kg: float) -> np.ndarray:
    """(N,) potential energy, J, of links with their mass in the middle."""
    spans = context.links * context.directions(q) * 1e-3  # type: ignore[attr-defined]
    ends = np.cumsum(spans, axis=-1)
    return GRAVITY * ((ends - spans / 2).imag @ links_kg + ends[:, -1].imag * tip_kg)


def test_the_torque_of_gravity_is_the_fall_of_potential_energy_with_the_angle() -> None:
    context = context_of()
    links_kg, tip_kg = np.array([0.05, 0.04, 0.02]), 0.1
    torque = context.gravity_torque(context.q_cmd, links_kg, np.array(tip_kg))
    for joint in range(3):
        step = np.zeros(3)
        step[joint] = 1e-6
        up, down = (potential_j(context, context.q_cmd + s * step, links_kg, tip_kg) for s in (1.0, -1.0))
        np.testing.assert_allclose(torque[:, joint], -(up - down) / 2e-6, atol=1e-7)


def test_an_arm_that_lies_flat_feels_no_gravity() -> None:
    context = context_of(upright=False)
    assert not context.has_gravity
    assert not context.declared_torque(context.q_cmd).any()


def test_the_clock_follows_time_where_it_is_known_and_the_order_otherwise() -> None:
    q = np.zeros((3, 3))
    np.testing.assert_allclose(context_of(q, time_s=np.array([5.0, 6.0, 15.0])).clock, [0.0, 0.1, 1.0])
    np.testing.assert_allclose(context_of(q, timed=False).clock, [0.0, 0.5, 1.0])


def test_a_clock_that_stands_still_gives_way_to_the_order() -> None:
    context = context_of(np.zeros((3, 3)), time_s=np.full(3, 7.0))
    np.testing.assert_allclose(context.clock, [0.0, 0.5, 1.0])
    np.testing.assert_allclose(context.elapsed_s, [0.0, 1.0, 2.0])


def test_waits_are_told_against_the_usual_one() -> None:
    context = context_of(np.zeros((5, 3)), time_s=np.array([0.0, 2.0, 4.0, 6.0, 10.0]))
    np.testing.assert_allclose(context.relative_waits[1:], [1.0, 1.0, 1.0, 2.0])


def test_where_no_masses_are_named_typical_ones_are_taken() -> None:
    from dataclasses import replace

    context = context_of()
    bare = replace(context, arm=replace(context.arm, link_masses_kg=None, tip_mass_kg=None))
    links, tip = bare.masses_kg
    assert len(links) == 3
    assert (links > 0).all()
    assert tip == pytest.approx(0.02, abs=0.02)
