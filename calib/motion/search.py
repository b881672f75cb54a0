"""The search of one joint: causes are added one at a time, each with all others fitted again, and dropped again.

A cause stays if the innovations of the remainder fall by more than chance makes of all that was tried, at the level of
the whole catalogue at all joints (Bonferroni). A form that explains as much as the best is its equivalent.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.motion.candidates import Form, Start, starts
from armtwin.calib.motion.fit import Fit, fit, robust_cost, scale_of, with_values
from armtwin.calib.motion.joint_model import JointModel, fitted_slots, noise_of
from armtwin.calib.motion.ladder import bare
from armtwin.calib.motion.problem import MotionProblem
from armtwin.calib.motion.refitting import FEW_ROUNDS, FIRST_ROUNDS, polished, with_form, without_form
from armtwin.calib.motion.screen import promises
from armtwin.calib.motion.series import Series, busiest, innovations, spread, whitening
from armtwin.calib.motion.weighing import AS_GOOD, better, threshold, weighs
from armtwin.models.catalogue.motion_effect import motion_catalogue
from armtwin.models.motion.loop import neutral

Array = NDArray[np.float64]

# Rounds of the search, and so causes and further steps at one joint.
_MOST_ROUNDS = 12
# A longer log is searched in its busiest stretches first.
_ROWS = 5000
# So many of the most promising candidates are fitted in full, one start of each form.
_FITTED = 4
# A rival that leaves less by this share takes a form's place.
_CLEARLY = 0.02
# A remainder that is this near to the noise, and without memory, is noise.
_AT_NOISE = 1.05


def search_joint(
    problem: MotionProblem,
    joint: int,
    base: Array | None = None,
    hear: Callable[[str], None] = lambda _: None,
    *,
    ties: bool = True,
    begin: JointModel | None = None,
) -> JointModel:
    """Find what is wrong with one joint, beyond what `base` holds (values of a loop; by default the nominal servo).

    Without `ties` rivals are not asked whether they explain as much: for a first look. A model to `begin` with was
    weighed by whole motions; droop and delay go where it is as good without.
    """
    series = problem.series[joint]
    if begin is not None:
        return bare(problem, series, _over(series, begin, geometric=begin.geometric))
    nominal = neutral() if base is None else base
    geometric = fit(series, nominal, fitted_slots(()), noise_of(series, series.remainder(nominal)), rounds=6)
    model = JointModel(joint, (), geometric, geometric, noise_of(series, geometric.e))
    if not problem.moves(joint):
        return model
    short = busiest(series, _ROWS)
    if short is not series:  # what explains the busiest stretches is looked for there, and asked of all rows
        found = _searched(problem, short, _over(short, model), hear)
        model = pruned(problem, series, polished(series, replace(found, geometric=geometric)), last=True)
    model = _searched(problem, series, model, hear)
    return weighed(problem, model) if ties else pruned(problem, series, model, last=True)


def weighed(problem: MotionProblem, model: JointModel) -> JointModel:
    """Ask each cause's rivals whether they explain as much, and drop what does not weigh."""
    series = problem.series[model.joint]
    return pruned(problem, series, _with_equivalents(problem, series, model), last=True)


def _over(series: Series, model: JointModel, geometric: Fit | None = None) -> JointModel:
    """Return a model with its remainder over another choice of rows."""
    e = series.remainder(model.fit.p)
    found = Fit(model.fit.p, e, robust_cost(e, scale_of(series, e, model.noise_rad)))
    return replace(model, fit=found, geometric=geometric or found, noise_rad=noise_of(series, e))


def _searched(problem: MotionProblem, series: Series, model: JointModel, hear: Callable[[str], None]) -> JointModel:
    """Add causes until none weighs any more."""
    for _ in range(_MOST_ROUNDS):
        if _is_noise(series, model):
            break
        grown = _grown(problem, series, model)
        if grown is None:
            break
        hear(f"{grown.forms[-1].effect} at joint {model.joint + 1}")
        model = pruned(problem, series, _exchanged(problem, series, grown))
    return model


def delayed(problem: MotionProblem, joint: int) -> JointModel:
    """Follow one joint with a delay alone: what a first look at all joints together begins with."""
    series = problem.series[joint]
    form = Form("latency", motion_catalogue()["latency"].forms[0])
    nominal = neutral()
    tried = [nominal]
    tried += [with_values(nominal, form.slots, [start]) for start in form.slots[0].starts]
    fits = [fit(series, p, fitted_slots((form,)), series.floor_rad, FIRST_ROUNDS) for p in tried]
    best = min(fits, key=lambda one: one.cost)
    return JointModel(joint, (form,), best, best, noise_of(series, best.e))


def _is_noise(series: Series, model: JointModel) -> bool:
    e = model.fit.e[series.used]
    new = innovations(e, whitening(e))
    return bool(spread(e) < _AT_NOISE * model.noise_rad and np.std(new) > 0.97 * np.std(e))


def _grown(problem: MotionProblem, series: Series, model: JointModel) -> JointModel | None:
    """Add the form that explains most, or None where none weighs."""
    best: JointModel | None = None
    for trial in _alternatives(problem, series, model, starts(problem, series, model.fit.p, model.fit.e, model.forms)):
        if not weighs(problem, series, model.fit.e, trial.fit.e, len(trial.forms[-1].slots)):
            continue
        if best is None or better(series, trial, best):
            best = trial
    if best is None:
        return None
    return polished(series, best)


def _exchanged(problem: MotionProblem, series: Series, model: JointModel) -> JointModel:
    """Put what an earlier form is taken for in its place, where that explains more now that others stand beside it."""
    for number in range(len(model.forms)):
        if number >= len(model.forms) or model.forms[number].ladder:
            continue
        gone = model.forms[number]
        rivals = _rivals(gone.effect) - set(model.effects)
        less = without_form(series, model, number, rounds=FEW_ROUNDS)
        tried = [s for s in starts(problem, series, less.fit.p, less.fit.e, less.forms) if s.form.effect in rivals]
        for trial in _alternatives(problem, series, less, tried):
            extra = max(0, len(trial.forms[-1].slots) - len(gone.slots))
            if trial.fit.cost * (1.0 + _CLEARLY * (1 + extra)) < model.fit.cost:
                model = polished(series, trial)
    return model


def _rivals(effect: str) -> set[str]:
    """Return what an effect is taken for, or is taken for it."""
    known = motion_catalogue()
    return {name for name in known if name in known[effect].confused_with or effect in known[name].confused_with}


def _alternatives(
    problem: MotionProblem, series: Series, model: JointModel, tried: Sequence[Start]
) -> Iterable[JointModel]:
    """Fit the most promising candidates beside what a model has."""
    scale = scale_of(series, model.fit.e, model.noise_rad)
    ranked = promises(series, model.fit.p, model.fit.e, model.slots, tried, scale)
    seen: dict[Form, int] = {}
    for promise in ranked:
        form = promise.start.form
        if form not in seen and len(seen) >= _FITTED:
            continue
        if seen.get(form, 0) >= (2 if any(slot.scanned for slot in form.slots) else 1):
            continue
        seen[form] = seen.get(form, 0) + 1
        yield with_form(series, model, form, promise.p)


def pruned(problem: MotionProblem, series: Series, model: JointModel, *, last: bool = False) -> JointModel:
    """Drop, one by one, what no longer weighs; what was added just now is asked at the `last` time only."""
    while len(model.forms) > (0 if last else 1):
        losses = []
        for number in range(len(model.forms) if last else len(model.forms) - 1):
            less = without_form(series, model, number)
            gone = [f for f in model.forms if f not in less.forms]
            n = sum(len(f.slots) for f in gone)
            if not weighs(problem, series, less.fit.e, model.fit.e, n, new=False):
                losses.append(less)
        if not losses:
            return model
        model = min(losses, key=lambda less: less.fit.cost)
        model = replace(model, noise_rad=noise_of(series, model.fit.e))
    return model


def _with_equivalents(problem: MotionProblem, series: Series, model: JointModel) -> JointModel:
    """Try what is taken for each effect in its place: take what explains more, and list what explains as much."""
    ties: list[tuple[str, str]] = []
    number = 0
    while number < len(model.forms):
        form = model.forms[number]
        if form.ladder:
            number += 1
            continue
        less = without_form(series, model, number)
        rivals = _rivals(form.effect) - set(less.effects)
        tried = [s for s in starts(problem, series, less.fit.p, less.fit.e, less.forms) if s.form.effect in rivals]
        swapped = False
        for trial in _alternatives(problem, series, less, tried):
            gain = series.gain(model.fit.e, trial.fit.e)
            if gain > AS_GOOD + threshold(1, 1) and trial.fit.cost < model.fit.cost:
                model = polished(series, trial)
                swapped = True
                break
            loss = series.gain(trial.fit.e, model.fit.e)
            if loss < AS_GOOD and len(trial.forms[-1].slots) <= len(form.slots):
                ties.append((form.effect, trial.forms[-1].effect))
        if not swapped:
            number += 1
        elif len(ties) > 20:
            break
    known = set(model.effects)
    kept = tuple(dict.fromkeys(t for t in ties if t[0] in known and t[1] not in known))
    return replace(model, equivalents=kept)
