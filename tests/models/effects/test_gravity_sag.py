"""Sag: joints give in proportion to the torque of gravity."""

import numpy as np
import pytest

from armtwin.models.catalogue.registry import Site, effect_named
from tests.support.contexts import context_of, turned


def test_the_tip_sinks() -> None:
    context = context_of()
    sagged = turned("gravity_sag", context, [0.05, 0.05, 0.05])
    tips = [(context.links * context.directions(q)).sum(axis=-1).imag for q in (context.q_cmd, sagged)]
    assert (tips[1] < tips[0]).all()


def test_a_joint_gives_by_its_compliance_times_its_torque() -> None:
    context = context_of()
    sag = turned("gravity_sag", context, [0.0, 1e-4, 0.0]) - context.q_cmd
    np.testing.assert_allclose(sag[:, 1], 1e-4 * context.declared_torque(context.q_cmd)[:, 1], rtol=1e-3)
    assert not sag[:, [0, 2]].any()


def test_a_softer_joint_is_solved_at_the_pose_to_which_it_has_sagged() -> None:
    context = context_of()
    sagged = turned("gravity_sag", context, [0.1, 0.1, 0.1])
    balance = 0.1 * context.declared_torque(sagged) - (sagged - context.q_cmd)
    first_guess = 0.1 * context.declared_torque(context.q_cmd) - (sagged - context.q_cmd)
    assert np.abs(balance).max() < 0.1 * np.abs(first_guess).max()


def test_a_declared_payload_sinks_it_further() -> None:
    light, heavy = context_of(), context_of(payload_kg=np.full(40, 0.2))
    sags = [np.abs(turned("gravity_sag", c, [0.05, 0.0, 0.0]) - c.q_cmd)[:, 0] for c in (light, heavy)]
    assert (sags[1] > sags[0]).all()


@pytest.mark.parametrize("name", ["gravity_sag", "link_bending", "payload"])
def test_weight_is_not_looked_for_in_an_arm_that_lies_flat(name: str) -> None:
    effect = effect_named(name)
    assert effect.applies(context_of(upright=False), Site(joint=1)) == "gravity has no part in the arm's plane"
    assert effect.applies(context_of(), Site(joint=1)) is None


def test_a_stiffening_spring_gives_the_less_the_further() -> None:
    context = context_of()
    soft, stiff = (
        turned("gravity_sag", context, [0.2] * 3 + [k] * 3 + [0.5, 1.0]) - context.q_cmd for k in (0.0, 400.0)
    )
    assert np.abs(stiff).max() < np.abs(soft).max()
    far, near = np.argmax(np.abs(soft[:, 0])), np.argmin(np.abs(soft[:, 0]))
    assert stiff[far, 0] / soft[far, 0] < stiff[near, 0] / soft[near, 0] < 1.0


def test_the_bench_makes_a_spring_that_stiffens_by_the_cube_of_its_angle() -> None:
    values = np.array([0.1, 0.1, 0.1, 10.0, 10.0, 10.0, 0.5, 1.0])
    context = context_of()
    built = effect_named("gravity_sag").built(context, Site(), values)
    assert built == {f"compliance{j}_rad_per_nm": 0.1 for j in (1, 2, 3)} | {
        f"stiffens{j}_per_rad2": 5.0 for j in (1, 2, 3)
    }
