"""Fitting a joint's model again: with a form more, with one less, with its thresholds scanned."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.motion.candidates import Form
from armtwin.calib.motion.fit import NEARLY_NOMINAL, Fit, fit, robust_cost, scale_of, with_values
from armtwin.calib.motion.joint_model import JointModel, fitted_slots, noise_of
from armtwin.calib.motion.series import Series
from armtwin.models.catalogue.motion_effect import Slot
from armtwin.models.motion.loop import INDEX

Array = NDArray[np.float64]

# Gauss-Newton steps of a first look, of a candidate, and of a model that stays.
FEW_ROUNDS, FIRST_ROUNDS, ROUNDS = 3, 5, 12


def polished(series: Series, model: JointModel) -> JointModel:
    """Fit all of a model once more, its thresholds too."""
    found = fit(series, model.fit.p, model.slots, model.noise_rad, ROUNDS)
    for slot in model.slots:
        if slot.scanned:
            found = _scanned(series, found, slot, model.slots, model.noise_rad)
    return replace(model, fit=found, noise_rad=noise_of(series, found.e))


def with_form(series: Series, model: JointModel, form: Form, p: Array) -> JointModel:
    """Return a model with one form more, fitted from `p` beside all others."""
    forms = (*model.forms, form)
    slots = fitted_slots(forms)
    found = fit(series, p, slots, model.noise_rad, FIRST_ROUNDS)
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
        at = float(values[lowest[len(lowest) // 2]])
    if at == start:
        return found
    return fit(series, with_values(found.p, [slot], [at]), slots, floor_rad, FIRST_ROUNDS)


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


def without_form(series: Series, model: JointModel, number: int, rounds: int = ROUNDS) -> JointModel:
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
    return without_form(series, model, first)
