"""Quantisation: commands land on whole multiples of a step."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from armtwin.models.catalogue.registry import Evidence
from armtwin.models.catalogue.rounding import roundings
from tests.support.contexts import context_of, one_joint, turned

PATHS = st.lists(st.floats(-1.5, 1.5), min_size=1, max_size=30)
STEPS = st.floats(1e-4, 0.3)


def rounded(path: object, step: float) -> np.ndarray:
    return turned("quantization", context_of(one_joint(1, path)), [step, 0.0])[:, 0]


@given(PATHS, STEPS)
def test_every_output_is_a_whole_number_of_steps(path: list[float], step: float) -> None:
    counts = rounded(path, step) / step
    np.testing.assert_allclose(counts, np.round(counts), atol=1e-6)


@given(PATHS, STEPS)
def test_no_output_is_more_than_half_a_step_away(path: list[float], step: float) -> None:
    assert (np.abs(rounded(path, step) - path) <= step / 2 + 1e-12).all()


@given(PATHS, STEPS)
def test_what_lies_on_the_grid_stays_there(path: list[float], step: float) -> None:
    once = rounded(path, step)
    np.testing.assert_allclose(rounded(once, step), once, atol=1e-12)


@given(PATHS, STEPS, st.floats(-0.1, 0.1))
def test_a_joint_counts_from_its_own_origin(path: list[float], step: float, origin: float) -> None:
    out = turned("quantization", context_of(one_joint(1, path)), [step, origin])
    counts = (out[:, 0] - origin) / step
    np.testing.assert_allclose(counts, np.round(counts), atol=1e-6)
    assert not out[:, 1:].any()


@pytest.mark.parametrize("steps", [(0.0175, 0.0175, 0.0175), (0.0123, 0.0, 0.0), (0.035, 0.0087, 0.0142)])
def test_each_joints_step_and_origin_show_in_what_its_commands_are_off_by(steps: tuple[float, ...]) -> None:
    rng = np.random.default_rng(5)
    commands, origins = rng.uniform(-0.5, 0.5, (200, 3)), (0.003, -0.002, 0.004)
    off = np.zeros_like(commands)
    for joint, (step, origin) in enumerate(zip(steps, origins, strict=True)):
        if step:
            off[:, joint] = np.floor((commands[:, joint] - origin) / step + 0.5) * step + origin - commands[:, joint]
    stiffness = np.tile(np.eye(3) / 3e-4**2, (200, 1, 1))
    shown = off + rng.normal(0.0, 3e-4, off.shape)
    found = roundings(Evidence(shown / 3e-4**2, stiffness, commands))
    for joint, step in enumerate(steps):
        one = found[joint]
        if not step:
            assert one is None
        else:
            assert one is not None
            assert one.step_rad == pytest.approx(step, rel=1e-3)
            assert abs((one.origin_rad - origins[joint] + step / 2) % step - step / 2) < 0.02 * step
