"""Faults of single samples: whether the diagnosis' own finders see them, on a few draws of the noise."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np

from armtwin.calib.diagnosis.acceptance import FIRST_SHARE, p_value_of
from armtwin.calib.diagnosis.candidates import CandidateModel
from armtwin.calib.diagnosis.fit import Data, excess_of, fit
from armtwin.calib.diagnosis.repairs import find_explained, repair
from armtwin.calib.diagnosis.search import repaired_again
from armtwin.calib.diagnosis.significance import LEVEL
from armtwin.models.catalogue.registry import effect_named
from armtwin.models.catalogue.site import Site
from armtwin.scenarios.power.arms import Arms
from armtwin.scenarios.power.contest import base_fit
from armtwin.scenarios.power.rule import NOTHING, Answers
from armtwin.scenarios.power.setting import data_without_noise, with_noise
from armtwin.sim.sealed import Wanted, hide
from armtwin.sim.sealed.of_size import draw_at

_FORMS = 4
_NOISES = 3


def event_answers(arms: Arms, effect: str, site: Site, size: float, rng: np.random.Generator) -> Answers:
    """Return what is said of recordings with an effect of single samples of a size."""
    said: Counter[str] = Counter()
    wanted = Wanted(effect, size, site)
    for number in range(_FORMS):
        bench, scene = arms.bench(number, effect)
        world = hide(bench, effect, (hidden := draw_at(rng, scene, wanted)), wanted.amplitude(hidden))
        clean = data_without_noise(scene, world)
        names = clean.problem.channels
        for _ in range(_NOISES):
            data = with_noise(clean, rng)
            seen = {name: data.problem.observed[:, k] for k, name in enumerate(names)}
            for detection in world.detections:
                seen = detection(seen, rng)
            observed = np.stack([seen[name] for name in names], axis=1)
            counts = data.counts & np.isfinite(observed).all(axis=-1)
            said[_answer(Data(replace(data.problem, observed=observed), counts, data.noise), effect, site)] += 1
    total = sum(said.values())
    return Answers(said[effect] / total, said)


def _answer(raw: Data, effect: str, site: Site) -> str:
    data, base = base_fit(raw)
    repaired, _, _ = repaired_again(data, repair(data, base), base)
    if effect_named(effect).found is not None and any(one.key[0] == effect for one in repaired.found):
        return "|".join(dict.fromkeys(one.key[0] for one in repaired.found))
    base = fit(repaired.data, base.g, ())
    for found in find_explained(repaired.data, base):
        model = fit(repaired.data, base.g, (found,))
        candidate = CandidateModel(found, model, 2.0 * float(np.log(len(base.misfit))) * len(found.values))
        gain = float(base.misfit.sum() - model.misfit.sum())
        if p_value_of(repaired.data, base, candidate) < LEVEL and gain > FIRST_SHARE * excess_of(repaired.data, base):
            return found.key[0]
    return NOTHING
