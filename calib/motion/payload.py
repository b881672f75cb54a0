"""An undeclared mass at the tip: the sag of several joints that follows one mass's pull, not the arm's own weight."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.motion.fit import fit, robust_cost, scale_of
from armtwin.calib.motion.joint_model import JointModel, noise_of
from armtwin.calib.motion.problem import MotionProblem, angles_of
from armtwin.calib.motion.search import pruned
from armtwin.models.motion.loads import tip_torques
from armtwin.models.motion.loop import INDEX
from armtwin.models.servo import nominal_servo

Array = NDArray[np.float64]

# One mass gives the joints of one kind of servo one sag a newton metre: theirs may differ by this share of the middle.
_ALIKE = 0.25
# It takes the weight's place where it leaves less by this share, and ties with it where it leaves no more by it.
_CLEARLY = 0.02


@dataclass(frozen=True, eq=False)
class Payload:
    """A mass at the tip, kg, behind nominal gears; `tied` where the arm's own weight explains the sag as well."""

    mass_kg: float
    joints: tuple[int, ...]
    tied: bool


Explained = tuple[MotionProblem, tuple[JointModel, ...], Payload]


def as_payload(problem: MotionProblem, models: tuple[JointModel, ...]) -> Explained | None:
    """Explain the sag of two joints or more by one mass at the tip; None where the arm's weight explains it better."""
    sagging = [model for model in models if "gravity_sag" in model.effects]
    if len(sagging) < 2:
        return None
    zeros = np.array([model.fit.p[INDEX["zero_rad"]] for model in models])
    pull = tip_torques(problem.recording.arm, angles_of(problem.recording, zeros))
    if pull is None:
        return None
    series, found = list(problem.series), list(models)
    before = after = 0.0
    sags = []
    for model in sagging:
        old = problem.series[model.joint]
        new = replace(old, load_nm=np.ascontiguousarray(pull[:, model.joint]))
        p = model.fit.p.copy()
        strength = float(np.std(old.load_nm)) / max(float(np.std(new.load_nm)), 1e-12)
        p[INDEX["droop_rad_nm"]] *= strength
        refit = fit(new, p, model.slots, model.noise_rad)
        scale = scale_of(old, model.fit.e, model.noise_rad)
        before += robust_cost(model.fit.e[old.used], scale) / scale**2
        after += robust_cost(refit.e[new.used], scale) / scale**2
        sags.append(float(refit.p[INDEX["droop_rad_nm"]]))
        series[model.joint] = new
        found[model.joint] = replace(model, fit=refit, noise_rad=noise_of(new, refit.e))
    middle = float(np.median(sags))
    if middle <= 0.0 or np.abs(np.array(sags) - middle).max() > _ALIKE * middle or after > (1.0 + _CLEARLY) * before:
        return None
    # Angles tell the mass times what a joint gives; the nominal servo's gear gives so much.
    mass = middle / nominal_servo().gear_compliance_rad_nm
    payload = Payload(mass, tuple(m.joint for m in sagging), after > (1.0 - _CLEARLY) * before)
    problem = replace(problem, series=tuple(series))
    for joint in payload.joints:  # what made up for the wrong load is no longer wanted
        model = pruned(problem, series[joint], found[joint], last=True)
        forms = tuple(form for form in model.forms if form.effect != "gravity_sag")
        ties = tuple(tie for tie in model.equivalents if tie[0] != "gravity_sag")
        found[joint] = replace(model, forms=forms, equivalents=ties)
    return problem, tuple(found), payload
