"""The diagnosis' rule, played on a contest of two models whose distances are known."""

from dataclasses import replace

import numpy as np
import pytest

from armtwin.scenarios.power.contest import Contest
from armtwin.scenarios.power.rule import NOTHING, UNKNOWN, answers


def _contest(explained: float, *, left: float = 0.0, rival: float | None = None, complexity: float = 7.0) -> Contest:
    """A fault that moves one coordinate, a true model that leaves `left` of it, a rival that explains `rival`."""
    remainders = [[np.sqrt(explained), np.sqrt(left), 0.0], [0.0, np.sqrt(left), 0.0]]
    keys = [("backlash", 1, None)]
    if rival is not None:
        remainders.append([np.sqrt(explained - rival), 0.0, 0.0])
        keys.append(("hysteresis", 1, None))
    R = np.array(remainders)
    n, values = len(keys), 800
    return Contest(
        keys=tuple(keys),
        distance=(R * R).sum(axis=1),
        gram=R @ R.T,
        parameters=np.ones(n, dtype=np.int64),
        complexity=np.full(n, complexity),
        typical=(R * R).sum(axis=1) / values,
        untimed=np.zeros(n, dtype=bool),
        as_free=np.eye(n, dtype=bool),
        runs=np.tile((R * R).sum(axis=1)[:, None] / 10.0, (1, 10)),
        free=values - 10,
        values=values,
        poses=100,
        tries=40,
    )


def _said(one: Contest, scale: float = 1.0) -> tuple[float, str]:
    told = answers(one, scale, np.random.default_rng(0))
    return told.found, told.said.most_common(1)[0][0]


def test_a_fault_below_the_noise_is_nothing_and_a_large_one_is_named() -> None:
    one = _contest(10.0)
    found, said = _said(one)
    assert found < 0.05
    assert said == NOTHING
    assert _said(one, scale=6.0) == (1.0, "backlash")


def test_a_larger_fault_is_found_as_often_or_more() -> None:
    one = _contest(60.0)
    found = [answers(one, scale, np.random.default_rng(1)).found for scale in (0.3, 0.6, 1.0, 1.4, 2.0)]
    assert found == sorted(found)
    assert found[0] < 0.1
    assert found[-1] > 0.9


def test_a_rival_that_explains_nearly_as_much_ties_and_one_that_explains_less_does_not() -> None:
    assert _said(_contest(400.0, rival=398.0))[1] in ("backlash|hysteresis", "hysteresis|backlash")
    assert _said(_contest(400.0, rival=200.0)) == (pytest.approx(1.0, abs=0.01), "backlash")


def test_a_term_that_leaves_much_of_a_large_fault_makes_it_unknown() -> None:
    assert _said(_contest(4000.0, left=900.0)) == (0.0, UNKNOWN)


def test_a_complex_cause_has_to_explain_more() -> None:
    simple, complicated = (answers(_contest(60.0, complexity=c), 1.0, np.random.default_rng(2)).found for c in (7, 60))
    assert simple > complicated + 0.3


def test_of_two_models_at_one_place_with_as_many_numbers_only_the_misfit_counts() -> None:
    one = _contest(400.0, rival=398.0)
    dearer = replace(one, complexity=np.array([30.0, 7.0]))
    told = answers(dearer, 1.0, np.random.default_rng(0)).said
    alike = answers(replace(dearer, as_free=np.ones((2, 2), dtype=bool)), 1.0, np.random.default_rng(0)).said
    assert told.most_common(1)[0][0] == "hysteresis"
    assert alike.most_common(1)[0][0] == "hysteresis|backlash"
