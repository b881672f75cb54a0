"""Steps back: a cause that another explains better is replaced, and what the data cannot tell apart is said."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from armtwin.calib.diagnosis.candidates import candidate_sites, candidates, fit_candidates
from armtwin.calib.diagnosis.fit import fit
from armtwin.calib.diagnosis.replacement import Ranked, rescanned, settle
from armtwin.models.catalogue.predict import Active
from armtwin.models.catalogue.registry import Site, effect_named
from tests.support.diagnoses import data_of, fitted, geometry_of
from tests.support.recordings import gain_of, recording


def quiet(_: str) -> None:
    pass


def test_a_cause_at_the_wrong_joint_is_replaced_by_the_one_that_is_there() -> None:
    data = data_of(recording(gain_of(2, 1.03)))
    wrong = fitted(data, "servo_nonlinearity", Site(joint=1), 0.01, 0.0, 2.0, 0.0, 0.0, 0.0, 0.0)
    settled, _ = settle(data, wrong, quiet)
    assert [effect.key for effect in settled.effects] == [("servo_gain", 2, None)]
    assert settled.deviance < wrong.deviance


def test_the_right_cause_stays_and_has_no_equivalents_where_the_poses_tell() -> None:
    data = data_of(recording(gain_of(2, 1.03)))
    right = fitted(data, "servo_gain", Site(joint=2), 1.0)
    settled, equivalents = settle(data, right, quiet)
    assert settled.effects[0].values[0] == right.effects[0].values[0]
    assert equivalents[("servo_gain", 2, None)] == ()


def test_candidates_that_were_fitted_before_stand_for_those_that_would_be_fitted_again() -> None:
    data = data_of(recording(gain_of(2, 1.03)))
    geometric, right = geometry_of(data), fitted(data, "servo_gain", Site(joint=2), 1.0)
    known = Ranked(data, candidates(data, geometric, candidate_sites(data)))
    anew, again = settle(data, right, quiet), settle(data, right, quiet, known)
    assert [effect.key for effect in again[0].effects] == [effect.key for effect in anew[0].effects]
    assert {key: len(ties) for key, ties in again[1].items()} == {key: len(ties) for key, ties in anew[1].items()}
    assert known.holds_for(data, geometric)
    assert not known.holds_for(replace(data, noise=0.5 * data.noise), geometric)
    moved = replace(data.problem.context, links=1.1 * data.problem.context.links)
    assert not known.holds_for(replace(data, problem=replace(data.problem, context=moved)), geometric)


def test_a_threshold_that_was_scanned_too_early_is_scanned_again_beside_a_later_cause() -> None:
    def bend(q: np.ndarray) -> np.ndarray:
        out = gain_of(2, 1.05)(q)
        out[:, 0] = np.round(q[:, 0] / 0.03) * 0.03
        return out

    data = data_of(recording(bend))
    early = fit_candidates(data, geometry_of(data), [(effect_named("quantization"), Site())])[0]
    gain = Active(effect_named("servo_gain"), Site(joint=2), np.array([1.0]))
    both = fit(data, early.fit.g, (*early.fit.effects, gain))
    again = rescanned(data, both)
    assert again.deviance <= both.deviance
    assert {effect.effect.name for effect in again.effects} == {"quantization", "servo_gain"}
