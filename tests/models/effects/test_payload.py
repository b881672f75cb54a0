"""A payload shows by the compliance of the joints."""

import numpy as np

from tests.support.contexts import context_of, turned

COMPLIANCE = [0.03, 0.02, 0.01]


def test_without_a_mass_only_the_arm_s_own_weight_is_carried() -> None:
    context = context_of()
    np.testing.assert_allclose(
        turned("payload", context, [0.0, 0.0, *COMPLIANCE]), turned("gravity_sag", context, COMPLIANCE)
    )


def test_a_mass_hangs_from_its_sample_on() -> None:
    context = context_of()
    without, with_it = (turned("payload", context, [mass, 15.0, *COMPLIANCE]) for mass in (0.0, 0.1))
    differs = (without != with_it).any(axis=1)
    assert not differs[:15].any()
    assert differs[15:].all()


def test_it_sags_as_a_declared_payload_of_the_same_mass_does() -> None:
    declared = context_of(payload_kg=np.full(40, 0.1))
    np.testing.assert_allclose(
        turned("payload", context_of(), [0.1, 0.0, *COMPLIANCE]), turned("gravity_sag", declared, COMPLIANCE)
    )


def test_a_rigid_arm_does_not_show_it() -> None:
    context = context_of()
    np.testing.assert_array_equal(turned("payload", context, [0.5, 0.0, 0.0, 0.0, 0.0]), context.q_cmd)
