"""The search of one joint: causes are added one at a time, each with all others fitted again, and dropped again.

A cause stays if the innovations of the remainder fall by more than chance makes of all that was tried, at the level of
the whole catalogue at all joints (Bonferroni). A form that explains as much as the best is its equivalent.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from armtwin.calib.motion.candidates import Form, starts
from armtwin.calib.motion.fit import NEARLY_NOMINAL, ZERO, Fit, fit, robust_cost, scale_of, with_values
from armtwin.calib.motion.problem import MotionProblem
from armtwin.calib.motion.screen import promises
from armtwin.calib.motion.series import Series, busiest, deviance_gain, innovations, spread, white_noise, whitening
from armtwin.models.catalogue.motion_effect import Slot, motion_catalogue
from armtwin.models.motion.loop import INDEX, neutral

Array = NDArray[np.float64]

# Level of the family of all effects at all joints: one false alarm in a thousand logs.
LEVEL = 1e-3
# Rounds of the search, and so causes and further steps at one joint.
_MOST_ROUNDS = 12
# A longer log is searched in its busiest stretches first.
_ROWS = 5000
# So many of the most promising candidates are fitted in full, one start of each form.
_FITTED = 4
_FEW_ROUNDS, _FIRST_ROUNDS, _ROUNDS = 3, 5, 12
# A motion of so many rows is asked; what some lose may be so much of what others gain.
_A_MOTION, _WORSE = 100, 0.15
# A rival that leaves less by this share takes a form's place.
_CLEARLY = 0.02
# A remainder that is this near to the noise, and without memory, is noise.
_AT_NOISE = 1.05
# A cause that takes away less than this of the remainder's innovations matters to nobody, whatever its significance;
# and one that takes less than this of what the remainder has beyond the noise is the imperfect form of the others.
_LEAST_SHARE = 0.004
_OF_THE_EXCESS = 0.08
# What moves the angles by less than so much of the readings' step (rounding has 0.29 of one), or of their noise, is no
# cause: rounding is no chance, and no twin is exact.
_OF_A_STEP, _OF_THE_NOISE = 0.35, 0.6
# Of two forms the one with fewer numbers is taken where it leaves no more than this beyond the other's.
_AS_GOOD = 8.0


@dataclass(frozen=True, eq=False)
class JointModel:
    """What was found at a joint (from 0).

    Attributes:
        joint: its index.
        forms: what was added, in the order of the search.
        fit: the loop's values and their remainder.
        geometric: the same with the zero alone.
        noise_rad: deviation of what has no memory.
        equivalents: for forms that another explains as well, that other's effect.

    """

    joint: int
    forms: tuple[Form, ...]
    fit: Fit
    geometric: Fit
    noise_rad: float
    equivalents: tuple[tuple[str, str], ...] = ()

    @property
    def slots(self) -> tuple[Slot, ...]:
        """All slots that are fitted."""
        return fitted_slots(self.forms)

    @property
    def effects(self) -> tuple[str, ...]:
        """Names of the effects, each once, in the order found."""
        return tuple(dict.fromkeys(form.effect for form in self.forms))


def fitted_slots(forms: Sequence[Form]) -> tuple[Slot, ...]:
    """Return the slots of forms, after those that are fitted always."""
    own = tuple(slot for form in forms for slot in form.slots)
    nearly = () if any(slot.slot == NEARLY_NOMINAL.slot for slot in own) else (NEARLY_NOMINAL,)
    return (ZERO, *nearly, *own)


def threshold(n_slots: int, n_tried: int) -> float:
    """Return the deviance that a form of so many numbers must win where so many forms were tried."""
    return float(chi2.isf(LEVEL / max(n_tried, 1), n_slots))


def noise_of(series: Series, e: Array) -> float:
    """Return the deviation of a remainder's part without memory, rad."""
    return white_noise(e[series.used], series.first[series.used], series.grain_rad)


def search_joint(
    problem: MotionProblem,
    joint: int,
    base: Array | None = None,
    hear: Callable[[str], None] = lambda _: None,
    *,
    ties: bool = True,
) -> JointModel:
    """Find what is wrong with one joint, beyond what `base` holds (values of a loop; by default the nominal servo).

    Without `ties` rivals are not asked whether they explain as much: for a first look.
    """
    series = problem.series[joint]
    nominal = neutral() if base is None else base
    geometric = fit(series, nominal, fitted_slots(()), noise_of(series, series.remainder(nominal)), rounds=6)
    model = JointModel(joint, (), geometric, geometric, noise_of(series, geometric.e))
    if not problem.moves(joint):
        return model
    short = busiest(series, _ROWS)
    if short is not series:  # what explains the busiest stretches is looked for there, and asked of all rows
        found = _searched(problem, short, _over(short, model), hear)
        model = pruned(problem, series, _polished(series, replace(found, geometric=geometric)), last=True)
    model = _searched(problem, series, model, hear)
    return weighed(problem, model) if ties else pruned(problem, series, model, last=True)


def weighed(problem: MotionProblem, model: JointModel) -> JointModel:
    """Ask each cause's rivals whether they explain as much, and drop what does not weigh."""
    series = problem.series[model.joint]
    return pruned(problem, series, _with_equivalents(problem, series, model), last=True)


def _over(series: Series, model: JointModel) -> JointModel:
    """Return a model with its remainder over another choice of rows."""
    e = series.remainder(model.fit.p)
    found = Fit(model.fit.p, e, robust_cost(e, scale_of(series, e, model.noise_rad)))
    return replace(model, fit=found, geometric=found, noise_rad=noise_of(series, e))


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
    floor = series.grain_rad / np.sqrt(12.0)
    nominal = neutral()
    tried = [nominal]
    tried += [with_values(nominal, form.slots, [start]) for start in form.slots[0].starts]
    fits = [fit(series, p, fitted_slots((form,)), floor, _FIRST_ROUNDS) for p in tried]
    best = min(fits, key=lambda one: one.cost)
    return JointModel(joint, (form,), best, best, noise_of(series, best.e))


def _is_noise(series: Series, model: JointModel) -> bool:
    e = model.fit.e[series.used]
    new = innovations(e, whitening(e))
    return bool(spread(e) < _AT_NOISE * model.noise_rad and np.std(new) > 0.97 * np.std(e))


def _tried(problem: MotionProblem) -> int:
    """Count what is tried: some thirty forms at each joint."""
    return 30 * problem.recording.n_joints


def _grown(problem: MotionProblem, series: Series, model: JointModel) -> JointModel | None:
    """Add the form that explains most, or None where none weighs."""
    best: JointModel | None = None
    for trial in _alternatives(problem, series, model, starts(problem, series, model.fit.p, model.fit.e, model.forms)):
        if not _weighs(problem, series, model.fit.e, trial.fit.e, len(trial.forms[-1].slots)):
            continue
        if best is None or _better(series, trial, best):
            best = trial
    if best is None:
        return None
    return _polished(series, best)


def _exchanged(problem: MotionProblem, series: Series, model: JointModel) -> JointModel:
    """Put what an earlier form is taken for in its place, where that explains more now that others stand beside it."""
    for number in range(len(model.forms)):
        if number >= len(model.forms) or model.forms[number].ladder:
            continue
        gone = model.forms[number]
        rivals = _rivals(gone.effect) - set(model.effects)
        less = _without(series, model, number, rounds=_FEW_ROUNDS)
        tried = [s for s in starts(problem, series, less.fit.p, less.fit.e, less.forms) if s.form.effect in rivals]
        for trial in _alternatives(problem, series, less, tried):
            extra = max(0, len(trial.forms[-1].slots) - len(gone.slots))
            if trial.fit.cost * (1.0 + _CLEARLY * (1 + extra)) < model.fit.cost:
                model = _polished(series, trial)
    return model


def _rivals(effect: str) -> set[str]:
    """Return what an effect is taken for, or is taken for it."""
    known = motion_catalogue()
    return {name for name in known if name in known[effect].confused_with or effect in known[name].confused_with}


def _polished(series: Series, model: JointModel) -> JointModel:
    """Fit all of a model once more, its thresholds too."""
    found = fit(series, model.fit.p, model.slots, model.noise_rad, _ROUNDS)
    for slot in model.slots:
        if slot.scanned:
            found = _scanned(series, found, slot, model.slots, model.noise_rad)
    return replace(model, fit=found, noise_rad=noise_of(series, found.e))


def _alternatives(
    problem: MotionProblem, series: Series, model: JointModel, tried: Sequence[object]
) -> Iterable[JointModel]:
    """Fit the most promising candidates beside what a model has."""
    scale = scale_of(series, model.fit.e, model.noise_rad)
    ranked = promises(series, model.fit.p, model.fit.e, model.slots, tried, scale)  # type: ignore[arg-type]
    seen: dict[Form, int] = {}
    for promise in ranked:
        form = promise.start.form
        if form not in seen and len(seen) >= _FITTED:
            continue
        if seen.get(form, 0) >= (2 if any(slot.scanned for slot in form.slots) else 1):
            continue
        seen[form] = seen.get(form, 0) + 1
        yield _fitted(series, model, form, promise.p)


def _fitted(series: Series, model: JointModel, form: Form, p: Array) -> JointModel:
    forms = (*model.forms, form)
    slots = fitted_slots(forms)
    found = fit(series, p, slots, model.noise_rad, _FIRST_ROUNDS)
    for slot in form.slots:
        if slot.scanned:
            found = _scanned(series, found, slot, slots, model.noise_rad)
    return replace(model, forms=forms, fit=found, noise_rad=noise_of(series, found.e))


def _scanned(series: Series, found: Fit, slot: Slot, slots: Sequence[Slot], floor_rad: float) -> Fit:
    """Try values of a threshold about the best, coarse and then fine; take the middle of the lowest step."""
    scale = scale_of(series, found.e, floor_rad)
    start = at = float(found.p[INDEX[slot.slot]])
    for trials in _trials(slot, found.p, series.row_s):
        values = at + trials
        costs = np.array([robust_cost(series.remainder(with_values(found.p, [slot], [v])), scale) for v in values])
        lowest = np.flatnonzero(costs <= costs.min() * (1.0 + 1e-4))
        middle = lowest[len(lowest) // 2]
        if costs[middle] <= costs.min() * (1.0 + 1e-4):
            at = float(values[middle])
    if at == start:
        return found
    return fit(series, with_values(found.p, [slot], [at]), slots, floor_rad, _FIRST_ROUNDS)


def _trials(slot: Slot, p: Array, row_s: float) -> list[Array]:
    """Return the departures from a threshold's value that are tried, coarse and then fine."""
    at = float(p[INDEX[slot.slot]])
    if slot.slot == "step_origin_rad":
        step = float(p[INDEX["step_rad"]])
        return [step * np.linspace(-0.4, 0.4, 33), step * np.linspace(-0.025, 0.025, 11)]
    if slot.slot.endswith("_s"):  # a moment
        return [row_s * np.arange(-12.0, 13.0)]
    if slot.slot == "step_rad":
        return [at * np.linspace(-0.004, 0.004, 33), at * np.linspace(-2.5e-4, 2.5e-4, 11)]
    return [at * np.linspace(-0.2, 0.25, 46), at * np.linspace(-0.01, 0.01, 21)]


def _weighs(
    problem: MotionProblem, series: Series, before: Array, after: Array, n_slots: int, *, new: bool = True
) -> bool:
    """Whether what `after` has beyond `before` is a cause; what stands already is asked less than what is `new`."""
    used = series.used
    moved = float(np.sqrt(np.mean((before - after)[used] ** 2)))
    if moved < max(_OF_A_STEP * series.grain_rad, _OF_THE_NOISE * noise_of(series, after)):
        return False
    least = used.sum() * noise_of(series, after) ** 2
    plain = float((before[used] ** 2).sum()), float((after[used] ** 2).sum())  # what stops an arm shows as gross errors
    capped = _squares(before[used]), _squares(after[used])
    if all(old - left < _OF_THE_EXCESS * (old - least) for old, left in (plain, capped)):
        return False
    if new and not _holds_in_all_motions(problem, used, before, after):
        return False
    gain = deviance_gain(before[used], after[used], series.grain_rad / np.sqrt(12.0))
    return gain > max(threshold(n_slots, _tried(problem)), _LEAST_SHARE * used.sum())


def _holds_in_all_motions(problem: MotionProblem, used: NDArray[np.bool_], before: Array, after: Array) -> bool:
    """Whether no motion is followed plainly worse: a delay, a lag or a friction is one number over all of them."""
    changes: list[float] = []
    for motion in problem.recording.motions:
        rows = problem.recording.rows_of(motion)
        rows = rows[used[rows]]
        if len(rows) >= _A_MOTION:
            changes.append(_squares(after[rows]) - _squares(before[rows]))
    worse, better = sum(c for c in changes if c > 0.0), -sum(c for c in changes if c < 0.0)
    return worse <= _WORSE * better


def _squares(e: Array) -> float:
    """Return the sum of squares, in which no reading counts for more than six deviations."""
    return float((np.minimum(np.abs(e), 6.0 * max(spread(e), 1e-12)) ** 2).sum())


def _better(series: Series, one: JointModel, other: JointModel) -> bool:
    """Whether one model explains the readings better than another; each number costs its share."""
    used = series.used
    gain = deviance_gain(other.fit.e[used], one.fit.e[used], series.grain_rad / np.sqrt(12.0))
    extra = len(one.forms[-1].slots) - len(other.forms[-1].slots)
    memory = (
        0.5
        * used.sum()
        * np.log(max(float(np.mean(other.fit.e[used] ** 2)), 1e-30) / max(float(np.mean(one.fit.e[used] ** 2)), 1e-30))
    )
    return gain + memory > _AS_GOOD * extra


def _without(series: Series, model: JointModel, number: int, rounds: int = _ROUNDS) -> JointModel:
    """Take a form out, with the further steps of its effect, and fit what is left again."""
    gone = model.forms[number]
    stay = tuple(
        form
        for k, form in enumerate(model.forms)
        if k != number and not (form.effect == gone.effect and not gone.ladder)
    )
    p = model.fit.p.copy()
    slots = fitted_slots(stay)
    kept = {slot.slot for slot in slots if slot is not NEARLY_NOMINAL}
    for form in model.forms:
        for slot in form.slots:
            if slot.slot not in kept:
                p[INDEX[slot.slot]] = model.geometric.p[INDEX[slot.slot]]
    found = fit(series, p, slots, model.noise_rad, rounds)
    return replace(model, forms=stay, fit=found)


def without(series: Series, model: JointModel, effect: str) -> JointModel:
    """Take an effect out with all its forms, and fit what is left again."""
    first = next(number for number, form in enumerate(model.forms) if form.effect == effect)
    return _without(series, model, first)


def pruned(problem: MotionProblem, series: Series, model: JointModel, *, last: bool = False) -> JointModel:
    """Drop, one by one, what no longer weighs; what was added just now is asked at the `last` time only."""
    while len(model.forms) > (0 if last else 1):
        losses = []
        for number, form in enumerate(model.forms if last else model.forms[:-1]):
            less = _without(series, model, number)
            gone = [f for f in model.forms if f not in less.forms]
            n = sum(len(f.slots) for f in gone)
            if not _weighs(problem, series, less.fit.e, model.fit.e, n, new=False):
                losses.append((less.fit.cost, less, form))
        if not losses:
            return model
        _, model, _ = min(losses, key=lambda loss: loss[0])
        model = replace(model, noise_rad=noise_of(series, model.fit.e))
    return model


def _with_equivalents(problem: MotionProblem, series: Series, model: JointModel) -> JointModel:
    """Try what is taken for each effect in its place: take what explains more, and list what explains as much."""
    ties: list[tuple[str, str]] = []
    number = 0
    used = series.used
    while number < len(model.forms):
        form = model.forms[number]
        if form.ladder:
            number += 1
            continue
        less = _without(series, model, number)
        rivals = _rivals(form.effect) - set(less.effects)
        tried = [s for s in starts(problem, series, less.fit.p, less.fit.e, less.forms) if s.form.effect in rivals]
        swapped = False
        for trial in _alternatives(problem, series, less, tried):
            gain = deviance_gain(model.fit.e[used], trial.fit.e[used], series.grain_rad / np.sqrt(12.0))
            if gain > _AS_GOOD + threshold(1, 1) and trial.fit.cost < model.fit.cost:
                model = _polished(series, trial)
                swapped = True
                break
            loss = deviance_gain(trial.fit.e[used], model.fit.e[used], series.grain_rad / np.sqrt(12.0))
            if loss < _AS_GOOD and len(trial.forms[-1].slots) <= len(form.slots):
                ties.append((form.effect, trial.forms[-1].effect))
        if not swapped:
            number += 1
        elif len(ties) > 20:
            break
    known = set(model.effects)
    kept = tuple(dict.fromkeys(t for t in ties if t[0] in known and t[1] not in known))
    return replace(model, equivalents=kept)
