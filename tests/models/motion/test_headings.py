"""What a load follows over the pose is found from the loads of a model, and holds for other masses and zeros."""

from __future__ import annotations

import numpy as np
import pytest

from armtwin.models.motion.headings import headings_of


def loads(q: np.ndarray, masses: tuple[float, ...], zeros: tuple[float, ...]) -> np.ndarray:
    """Torques of three links that turn in the senses 1, -1, 1, with a mass at each end."""
    heading = np.cumsum((q + zeros) * (1, -1, 1), axis=1)
    reach = 0.1 * np.cos(heading)
    return np.stack(
        [sum(m * 9.81 * reach[:, j : k + 1].sum(1) for k, m in enumerate(masses) if k >= j) for j in range(3)], 1
    )


def test_the_senses_of_a_chain_are_found() -> None:
    q = np.random.default_rng(1).uniform(-1, 1, (500, 3))
    found = headings_of(q, loads(q, (0.1, 0.2, 0.1), (0.0, 0.0, 0.0)))
    assert found is not None
    assert (found.joints, found.senses) == ((0, 1, 2), (1, -1, 1))


def test_headings_hold_the_loads_of_other_masses_at_other_zeros() -> None:
    q = np.random.default_rng(2).uniform(-1, 1, (500, 3))
    found = headings_of(q, loads(q, (0.1, 0.2, 0.1), (0.0, 0.0, 0.0)))
    assert found is not None
    other = loads(q, (0.3, 0.1, 0.2), (0.2, -0.3, 0.1))
    for joint in range(3):
        X = found.basis(q, joint)
        share = np.linalg.lstsq(X, other[:, joint], rcond=None)[0]
        assert X @ share == pytest.approx(other[:, joint], abs=1e-9)


def test_loads_that_follow_no_chain_have_no_headings() -> None:
    rng = np.random.default_rng(3)
    assert headings_of(rng.uniform(-1, 1, (500, 3)), rng.normal(size=(500, 3))) is None
