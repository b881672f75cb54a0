"""Whether what was found holds in every motion: delay, lag and friction asked of each motion alone.

A delay is one number over all motions, or it is not a delay but friction or lag that looks like one.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from armtwin.calib.motion.candidates import Form
from armtwin.calib.motion.fit import fit, with_values
from armtwin.calib.motion.identify import ArmModel
from armtwin.calib.motion.joint_model import JointModel
from armtwin.calib.motion.series import busiest, rms
from armtwin.calib.motion.uncertainty import deviations
from armtwin.models.catalogue.motion_effect import Slot
from armtwin.models.motion.loop import INDEX

# What is one number of the arm; a whole arm's delay is a slot of every joint.
_ASKED = ("delay_s", "time_constant_s", "coulomb_rad")
_DELAY = Slot("delay_s", "delay_s", (0.0, 0.5), (0.0,), 0.005)
_LAG = Slot("time_constant_s", "time_constant_s", (0.005, 0.6), (0.05,), 0.005)
_MORE_THAN_NOISE = 1.5
# A motion of fewer rows, or in which the joint moves less than this, says nothing of its own.
_LEAST_ROWS, _LEAST_MOVE_RAD = 100, 0.1
_ROWS, _ROUNDS = 1500, 6
# A motion's number is another where it is off by so many deviations, and by so much that it matters.
_PLAINLY, _MATTERS = 4.0, 0.15


@dataclass(frozen=True)
class InMotion:
    """A parameter of a joint (from 0) as one motion has it, with its deviation where that can be said."""

    joint: int
    parameter: str
    motion: str
    value: float
    std: float | None
    over_all: float

    @property
    def differs(self) -> bool:
        """Whether this motion plainly has another number than all of them together."""
        off = abs(self.value - self.over_all)
        return self.std is not None and off > _PLAINLY * self.std and off > _MATTERS * abs(self.over_all)


def by_motion(arm: ArmModel) -> tuple[InMotion, ...]:
    """Return each joint's delay, lag and friction as every fitted motion has it, all else as it was found.

    A joint of which nothing was named though more than noise is left is asked for a delay and a lag.
    """
    out: list[InMotion] = []
    for model in arm.joints:
        if not arm.problem.moves(model.joint):
            continue
        slots = tuple(slot for form in model.forms for slot in form.slots if slot.slot in _ASKED)
        if arm.delay_s is not None:
            slots = (*slots, _DELAY)
        used = arm.problem.series[model.joint].used
        if not slots and rms(model.fit.e[used]) > _MORE_THAN_NOISE * model.noise_rad:
            slots = (_DELAY, _LAG)
            series = busiest(arm.problem.series[model.joint], 2 * _ROWS)
            p = with_values(model.fit.p, [_LAG, _DELAY], [2.0 * model.fit.p[INDEX["time_constant_s"]], 0.02])
            model = replace(model, fit=fit(series, p, slots, model.noise_rad, 2 * _ROUNDS))
        if slots:
            out += _of_joint(arm, model, slots)
    return tuple(out)


def _of_joint(arm: ArmModel, model: JointModel, slots: tuple[Slot, ...]) -> list[InMotion]:
    problem, out = arm.problem, []
    for motion in problem.recording.motions:
        whole = problem.whole(model.joint, motion)
        used = whole.used & problem.fitted
        if used.sum() < _LEAST_ROWS or np.ptp(whole.sent[used]) < _LEAST_MOVE_RAD:
            continue
        series = busiest(replace(whole, used=used), _ROWS)
        found = fit(series, model.fit.p, slots, model.noise_rad, _ROUNDS)
        std = deviations(series, replace(model, forms=(Form("asked", slots),), fit=found))
        for slot in slots:
            at = INDEX[slot.slot]
            value, over_all = float(found.p[at]), float(model.fit.p[at])
            out.append(InMotion(model.joint, slot.parameter, motion, value, std.get(slot.slot), over_all))
    return out
