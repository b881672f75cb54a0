"""How a joint rubs: rungs from no friction to one that grows with the load, and the one that predicts best.

A log of several motions is asked first for what every geared servo has: a delay, a lag, friction, and a droop under
the load. Each rung is fitted to all motions but one and asked for that one, in turn (cross-validation by whole
motions): the rung that predicts best is taken, not the richest. Play stands beside friction and is asked the same; a
joint at which it predicts better, or at which friction does not weigh, is left to the search.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.motion.candidates import Form
from armtwin.calib.motion.fit import Fit, robust_cost, scale_of
from armtwin.calib.motion.joint_model import JointModel, noise_of
from armtwin.calib.motion.obstructed import obstructed
from armtwin.calib.motion.problem import MotionProblem
from armtwin.calib.motion.refitting import without
from armtwin.calib.motion.series import Series, rms
from armtwin.calib.motion.shaped import Shape, Shaped, bearing, fit_shaped
from armtwin.models.catalogue.motion_effect import Slot, motion_catalogue
from armtwin.models.motion.loop import INDEX, neutral

Array = NDArray[np.float64]

# So many fitted motions make a cross-validation, each of so many rows.
_MOTIONS, _ROWS_OF_A_MOTION = 3, 200
# A rung has to predict better than a poorer one by this share of a motion's error, in the mean.
_BETTER = 0.04
# Play that predicts as well as friction to this share is told as its equivalent.
_AS_WELL = 0.03
# Friction that takes less than this of the error of delay and lag is left to the search.
_WEIGHS = 0.12
# Where delay and lag alone come this near to the noise, nothing rubs.
_NEAR_NOISE = 3.0
# Stribeck's part at the start, times Coulomb's, and its speeds, rad/s: between them the fit has valleys of its own.
_PARTS, _SPEEDS = (1.0, 2.0), (0.03, 0.09, 0.25)
_FEW, _MANY, _AGAIN = 4, 10, 2


@dataclass(frozen=True)
class _Rung:
    name: str
    slots: tuple[Slot, ...]


@dataclass(frozen=True, eq=False)
class Climbed:
    """A joint that was followed by friction.

    Attributes:
        series: with the load as it was found.
        model: what was found.
        obstructed: rows in which something was in its way; they are left out.
        scores: mean logarithm of the error at motions that each rung was not fitted to.
        load_of_basis: (k,) N m for each column of its load's basis.

    """

    series: Series
    model: JointModel
    obstructed: NDArray[np.intp]
    scores: dict[str, float]
    load_of_basis: Array

    def load_nm(self, problem: MotionProblem, q: Array) -> Array:
        """(N,) load, N m, with the arm at angles q (N, n), rad."""
        return np.asarray(_basis(problem, self.model.joint, q) @ self.load_of_basis)


def climb(problem: MotionProblem, joint: int, base: Array | None = None) -> Climbed | None:
    """Find how one joint rubs; None where its log cannot tell, or is explained otherwise."""
    series = problem.series[joint]
    motions = motions_of(problem, series)
    if len(motions) < _MOTIONS or not problem.moves(joint) or not series.turns_back:
        return None
    shape, mix = Shape.of(_basis(problem, joint, problem.angles), series.used)
    return _Climb(problem, joint, series, shape, mix, motions, base).top()


class _Climb:
    def __init__(
        self,
        problem: MotionProblem,
        joint: int,
        series: Series,
        shape: Shape,
        mix: Array,
        motions: list[NDArray[np.intp]],
        base: Array | None,
    ) -> None:
        self.problem, self.joint, self.series, self.shape, self.motions = problem, joint, series, shape, motions
        self.mix = mix
        self.nominal = neutral() if base is None else base
        known = motion_catalogue()
        self.first = (known["latency"].forms[0][0], known["servo_lag"].forms[0][0])
        self.coulomb = known["friction"].forms[0][0]
        self.stribeck = known["friction"].forms[1][1:]
        self.further = {steps[0].slot: steps[0] for steps in known["friction"].further if len(steps) == 1}
        self.play = known["backlash"].forms[0][0]

    def top(self) -> Climbed | None:
        plain = self._fit(self._begin(), (*self.first, self.coulomb))
        plain = self._with_stribeck(plain)
        rows = obstructed(self.series, plain.e)
        if len(rows):
            used = self.series.used.copy()
            used[rows] = False
            self.series = replace(self.series, used=used)
            plain = self._fit((plain.p, plain.amplitudes), (*self.first, self.coulomb, *self.stribeck))
        rungs = self._rungs()
        found: dict[str, tuple[Shaped, float]] = {}
        at = plain
        for rung in rungs:
            start = at if rung.name != "play" else plain
            fitted = self._fit((self._started(start, rung), start.amplitudes), rung.slots, _MANY)
            found[rung.name] = (fitted, self._score(fitted, rung.slots))
            if rung.name not in ("none", "play"):
                at = fitted
        scores = {name: score for name, (_, score) in found.items()}
        best = rungs[1]
        for rung in rungs[2:]:
            if rung.name != "play" and scores[rung.name] < scores[best.name] - _BETTER:
                best = rung
        near = _NEAR_NOISE * noise_of(self.series, found[best.name][0].e)
        if np.exp(scores["none"]) < near or scores[best.name] > min(
            scores["none"] - _WEIGHS, scores["play"] + _AS_WELL
        ):
            return None
        ties = (("friction", "backlash"),) if scores["play"] < scores[best.name] + _AS_WELL else ()
        return self._climbed(found[best.name][0], best, ties, rows, scores)

    def _begin(self) -> tuple[Array, Array]:
        p = self.nominal.copy()
        for slot, value in zip((*self.first, self.coulomb), (0.03, 0.06, 0.008), strict=True):
            p[INDEX[slot.slot]] = value
        short = self.series.sent - self.series.measured
        return p, self.shape.amplitudes(short, self.series.used)

    def _fit(self, start: tuple[Array, Array], slots: tuple[Slot, ...], rounds: int = _MANY) -> Shaped:
        return fit_shaped(self.series, self.shape, start, slots, rounds)

    def _with_stribeck(self, plain: Shaped) -> Shaped:
        slots = (*self.first, self.coulomb, *self.stribeck)
        tried = [plain]
        for part in _PARTS:
            for speed in _SPEEDS:
                p = plain.p.copy()
                dry = max(float(p[INDEX["coulomb_rad"]] + p[INDEX["stribeck_rad"]]), 2.0 * self.series.grain_rad)
                p[INDEX["coulomb_rad"]] = 0.5 * dry
                p[INDEX["stribeck_rad"]] = part * dry
                p[INDEX["stribeck_speed_rad_s"]] = speed
                tried.append(self._fit((p, plain.amplitudes), slots, _FEW))
        best = min(tried, key=self._typical)
        return self._fit((best.p, best.amplitudes), slots)

    def _typical(self, one: Shaped) -> float:
        return log_error(self.series, one.e, self.motions)

    def _rungs(self) -> list[_Rung]:
        rubbing = (*self.first, self.coulomb, *self.stribeck)
        rungs = [_Rung("none", self.first), _Rung("coulomb", rubbing[:3]), _Rung("stribeck", rubbing)]
        if self.shape.columns.shape[1]:
            rubbing = (*rubbing, self.further["load_share"], self.further["stribeck_load_share"])
            rungs.append(_Rung("load", rubbing))
        rungs.append(_Rung("drive", (*rubbing, self.further["drive_share"], self.further["stribeck_drive_share"])))
        return [*rungs, _Rung("play", (*self.first, self.play))]

    def _started(self, at: Shaped, rung: _Rung) -> Array:
        """Return the values that a rung begins with: the last one's without what it lacks, what is new small."""
        p = at.p.copy()
        has = {slot.slot for slot in rung.slots}
        dry = float(p[INDEX["coulomb_rad"]] + p[INDEX["stribeck_rad"]])
        rubbing = {self.coulomb.slot, *self.further, *(slot.slot for slot in self.stribeck)}
        for name in (rubbing - has) | ({self.play.slot} - has):
            p[INDEX[name]] = self.nominal[INDEX[name]]
        if rung.name == "coulomb":
            p[INDEX["coulomb_rad"]] = dry
        if rung.name == "play":
            p[INDEX[self.play.slot]] = 2.0 * dry
        for name in set(self.further) & has:
            p[INDEX[name]] = max(float(p[INDEX[name]]), 0.03)
        return p

    def _score(self, fitted: Shaped, slots: tuple[Slot, ...]) -> float:
        """Return the mean logarithm of the error at each motion by a fit to the others."""
        errors = []
        for rows in self.motions:
            kept = np.zeros(len(self.series), dtype=bool)
            kept[rows] = True
            others = replace(self.series, used=self.series.used & ~kept, wanted=self.series.wanted & ~kept)
            one = fit_shaped(others, self.shape, (fitted.p, fitted.amplitudes), slots, _AGAIN)
            alone = replace(self.series, used=self.series.used & kept, wanted=kept)
            e = bearing(alone, self.shape, one.amplitudes).remainder(one.p)
            errors.append(log_error(alone, e, [rows]))
        return float(np.mean(errors))

    def _climbed(
        self,
        found: Shaped,
        rung: _Rung,
        ties: tuple[tuple[str, str], ...],
        rows: NDArray[np.intp],
        scores: dict[str, float],
    ) -> Climbed:
        series, p = self.series, found.p.copy()
        forms = [Form("latency", self.first[:1]), Form("servo_lag", self.first[1:])]
        forms.append(Form("friction", rung.slots[2:]))
        load_of_basis = np.zeros(0)
        if len(found.amplitudes):
            sag, load = self.shape.columns @ found.amplitudes, series.load_nm
            droop = float(np.std(sag[series.used])) / max(float(np.std(load[series.used])), 1e-9)
            series = replace(series, load_nm=np.ascontiguousarray(sag / droop))
            load_of_basis = self.mix @ found.amplitudes / droop
            p[INDEX["droop_rad_nm"]] = droop
            forms.append(Form("gravity_sag", motion_catalogue()["gravity_sag"].forms[0]))
        model = _model(series, self.joint, tuple(forms), p, self.nominal, ties)
        return Climbed(series, model, rows, scores, load_of_basis)


def _model(
    series: Series, joint: int, forms: tuple[Form, ...], p: Array, nominal: Array, ties: tuple[tuple[str, str], ...]
) -> JointModel:
    def as_fit(values: Array) -> Fit:
        e = series.remainder(values)
        return Fit(values, e, robust_cost(e, scale_of(series, e, noise_of(series, e))))

    still = nominal.copy()
    still[INDEX["zero_rad"]] = -float(np.median(series.remainder(nominal)[series.used]))
    found = as_fit(p)
    return JointModel(joint, forms, found, as_fit(still), noise_of(series, found.e), ties)


def bare(problem: MotionProblem, series: Series, model: JointModel) -> JointModel:
    """Take droop and delay out of a climbed joint's model where it follows the motions as well without."""
    motions = motions_of(problem, series)
    for effect in ("gravity_sag", "latency"):
        if effect in model.effects:
            less = without(series, model, effect)
            if log_error(series, less.fit.e, motions) < log_error(series, model.fit.e, motions) + _BETTER:
                model = less
    return model


def _basis(problem: MotionProblem, joint: int, q: Array) -> Array:
    """(N, k) what a joint's load is made of at angles q (N, n), rad."""
    if problem.headings is None:
        return np.zeros((len(q), 0))
    return problem.headings.basis(q, joint)


def log_error(series: Series, e: Array, motions: list[NDArray[np.intp]]) -> float:
    """Return the mean logarithm of a remainder over motions: each counts by its own size, above the readings' step."""
    errors = [rms(e[rows[series.used[rows]]]) for rows in motions]
    return float(np.mean(np.log(np.maximum(errors, max(series.grain_rad, 1e-5)))))


def motions_of(problem: MotionProblem, series: Series) -> list[NDArray[np.intp]]:
    """List the rows of each motion of which enough count."""
    rows = [problem.recording.rows_of(name) for name in problem.recording.motions]
    return [one for one in rows if int(series.used[one].sum()) >= _ROWS_OF_A_MOTION]
