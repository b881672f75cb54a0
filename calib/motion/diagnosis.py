"""The diagnosis of a moving recording: causes with intervals, what is left, and the gain on held-out motions."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from armtwin.calib.motion.by_motion import InMotion, by_motion
from armtwin.calib.motion.held_out import Gain, HeldOut, held_out, without_a_gain
from armtwin.calib.motion.identify import ArmModel, identify
from armtwin.calib.motion.joint_model import JointModel
from armtwin.calib.motion.ladder import log_error, motions_of
from armtwin.calib.motion.problem import MotionProblem, motion_problem
from armtwin.calib.motion.refitting import without
from armtwin.calib.motion.series import rms
from armtwin.calib.motion.set_up import SetUpFault, mended
from armtwin.calib.motion.uncertainty import deviations
from armtwin.models.motion.loop import INDEX, neutral
from armtwin.models.recordings.moving import MovingRecording
from armtwin.models.tabular import html_table

Array = NDArray[np.float64]

# What no chance makes of a hundred readings or more, times the noise.
_LOUD = 1.5
# The share of the squares at a joint that a model may leave whose form is not quite the arm's.
_LEFT_SHARE = 0.1
# Of a joint that was followed by friction the motions' errors are to fall to so much, as a logarithm.
_HALVED = float(np.log(0.6))
# What leaves so much of how the readings wander, though the joint is plainly sent about, explains nothing.
_STRANGE, _PLAIN_MOVE_RAD = 0.7, 0.02


@dataclass(frozen=True)
class Estimate:
    """A parameter's value and standard deviation, in the parameter's unit; None where no interval can be given."""

    value: float
    std: float | None


@dataclass(frozen=True, eq=False)
class MotionCause:
    """One cause: its effect, its joint (from 1) or the whole arm, and what was found of it.

    Attributes:
        effect, joint: joint is None for the whole arm.
        parameters: by name.
        equivalents: effects of the same joint that explain as much.
        p_value: of the likelihood ratio without it.
        explained_percent: share of the squares without it that it takes away, on the fitted rows.
        rows: the rows that it was found in, for one of single rows.

    """

    effect: str
    joint: int | None
    parameters: Mapping[str, Estimate]
    equivalents: tuple[str, ...] = ()
    p_value: float = 0.0
    explained_percent: float = 0.0
    rows: tuple[int, ...] = ()


@dataclass(frozen=True, eq=False)
class MotionDiagnosis:
    """What was found in a moving recording.

    Attributes:
        verdict: none, named, ambiguous or unknown, as of a settled recording.
        causes: the strongest first.
        arm: the models that they are read from.
        loud: joints (from 0) whose remainder is more than noise and is explained by nothing.
        held_out: for each held-out motion and joint.
        gain: over all of them.
        set_up: gross errors of the set-up, which were mended first.
        kept: what was predicted, by model and joint.

    """

    verdict: str
    causes: tuple[MotionCause, ...]
    arm: ArmModel
    loud: tuple[int, ...]
    held_out: tuple[HeldOut, ...]
    gain: Gain
    set_up: tuple[SetUpFault, ...] = ()
    kept: dict[tuple[str, int], Array] = field(default_factory=dict, repr=False)

    @cached_property
    def by_motion(self) -> tuple[InMotion, ...]:
        """Delay, lag and friction as each motion alone has them."""
        return by_motion(self.arm)

    @property
    def problem(self) -> MotionProblem:
        """The recording as it was looked at."""
        return self.arm.problem

    def predicted(self, which: Literal["nominal", "before", "after"]) -> Array:
        """(N, n) angles by the nominal servo, with the zeros fitted, or with the causes, rad, motion by motion."""
        return np.stack([self.predicted_joint(which, joint) for joint in range(self.recording.n_joints)], axis=-1)

    def predicted_joint(self, which: str, joint: int) -> Array:
        """(N,) the same of one joint (from 0); kept, for a report asks again and again."""
        if (which, joint) not in self.kept:
            self.kept[which, joint] = self._predicted_joint(which, joint)
        return self.kept[which, joint]

    def _predicted_joint(self, which: str, joint: int) -> Array:
        model = self.arm.joints[joint]
        believed = model.geometric.p if joint in self.loud else model.fit.p
        p = {"nominal": neutral(), "before": model.geometric.p, "after": believed}[which]
        return replace(self.problem.series[joint], wanted=np.ones(len(self.recording), dtype=bool)).predicted(p)

    @property
    def recording(self) -> MovingRecording:
        """The recording."""
        return self.arm.problem.recording

    def columns(self) -> dict[str, list[Any]]:
        """Return a row a parameter of each cause: effect, joint, parameter, value, standard deviation."""
        rows = [(cause, name, one) for cause in self.causes for name, one in cause.parameters.items()]
        return {
            "effect": [cause.effect for cause, *_ in rows],
            "joint": [cause.joint for cause, *_ in rows],
            "parameter": [name for _, name, _ in rows],
            "value": [one.value for *_, one in rows],
            "std": [one.std for *_, one in rows],
        }

    def _repr_html_(self) -> str:
        before, after = (
            1e3 * float(np.sqrt(np.mean([getattr(one, f"{key}_rms_rad") ** 2 for one in self.held_out] or [0.0])))
            for key in ("before", "after")
        )
        return html_table(
            f"Diagnosis in motion: {self.verdict}; {before:.3g} → {after:.3g} mrad on held-out motions", self.columns()
        )


def diagnose_motion(recording: MovingRecording, tell: Callable[[str], None] = lambda _: None) -> MotionDiagnosis:
    """Diagnose a moving recording; raises `RecordingError` where nothing can be decided."""
    tell("looking for gross errors of the set-up")
    right = mended(recording)
    problem = motion_problem(right.recording)
    arm = identify(problem, tell)
    tell("asking the held-out motions")
    arm = without_a_gain(arm)
    loud = tuple(model.joint for model in arm.joints if _is_loud(arm, model))
    tell("weighing intervals")
    causes = sorted(_causes(arm, loud), key=lambda cause: -cause.explained_percent)
    if loud:
        verdict = "unknown"
    elif not causes:
        verdict = "none"
    else:
        verdict = "ambiguous" if any(cause.equivalents for cause in causes) else "named"
    motions = held_out(arm, loud)
    return MotionDiagnosis(verdict, tuple(causes), arm, loud, motions, Gain.over(motions), right.faults)


def _is_loud(arm: ArmModel, model: JointModel) -> bool:
    if not arm.problem.is_read(model.joint):
        return False
    series = arm.problem.series[model.joint]
    used = series.used
    left, noise = rms(model.fit.e[used]), model.noise_rad
    readings, sent = series.measured[used], series.sent[used]
    if arm.problem.moves(model.joint) and left > _STRANGE * np.std(readings) and np.std(sent) > _PLAIN_MOVE_RAD:
        return True
    if left < _LOUD * noise:
        return False
    if model.joint in arm.climbed:  # its motions were weighed each by its own size
        motions = motions_of(arm.problem, series)
        return log_error(series, model.fit.e, motions) > log_error(series, model.geometric.e, motions) + _HALVED
    if not model.forms and arm.delay_s is None and arm.late is None and arm.payload is None:
        return True
    return left**2 - noise**2 > _LEFT_SHARE * max(rms(model.geometric.e[used]) ** 2 - noise**2, 0.0)


def _causes(arm: ArmModel, loud: tuple[int, ...]) -> list[MotionCause]:
    out = []
    for model in arm.joints:
        if model.joint not in loud:
            out += _of_joint(arm, model)
    quiet = [model for model in arm.joints if model.joint not in loud and arm.problem.moves(model.joint)]
    if arm.delay_s is not None and quiet:
        spread = [deviations(arm.problem.series[m.joint], m).get("delay_s") for m in quiet]
        known = [s for s in spread if s]
        std = float(1.0 / np.sqrt(sum(1.0 / s**2 for s in known))) if known else None
        out.append(
            MotionCause("latency", None, {"delay_s": Estimate(arm.delay_s, std)}, (), 0.0, _shared_percent(quiet, arm))
        )
    sampled = sampling_values(arm)
    if sampled and quiet:
        out.append(MotionCause("sampling", None, sampled, (), 0.0, _shared_percent(quiet, arm)))
    if arm.payload is not None and not set(arm.payload.joints) & set(loud):
        ties = ("gravity_sag",) if arm.payload.tied else ()
        mass = {"mass_kg": Estimate(arm.payload.mass_kg, None)}
        sagging = [arm.joints[joint] for joint in arm.payload.joints]
        out.append(MotionCause("payload", None, mass, ties, 0.0, _shared_percent(sagging, arm)))
    for joint, one in arm.climbed.items():
        if len(one.obstructed) and joint not in loud:
            out.append(MotionCause("contact", joint + 1, {}, rows=tuple(int(r) for r in one.obstructed)))
    for joint, rows in arm.gross.items():
        sizes = np.abs(_gross_sizes(arm, joint))
        share = len(rows) / max(int(arm.problem.fitted.sum()), 1)
        values = {"rate": Estimate(share, None), "size_rad": Estimate(float(np.median(sizes)), None)}
        out.append(MotionCause("outliers", joint + 1, values, rows=tuple(int(r) for r in rows)))
    if arm.missed_by_all:
        rows = np.unique(np.concatenate(list(arm.missed.values())))
        out.append(MotionCause("missed_command", None, {}, rows=tuple(int(r) for r in rows)))
    else:
        for joint, rows in arm.missed.items():
            out.append(MotionCause("missed_command", joint + 1, {}, rows=tuple(int(r) for r in rows)))
    return out


def sampling_values(arm: ArmModel) -> dict[str, Estimate]:
    """Return what is wrong with the sampling, by parameter; empty where nothing is."""
    values = {}
    if arm.late is not None:
        values = {"from_s": Estimate(arm.late.from_s, None), "delay_s": Estimate(arm.late.late_s, None)}
    if arm.bus is not None:
        values |= {
            "from_s": Estimate(arm.bus.from_s, float(arm.bus.within_s / np.sqrt(12.0))),
            "held_rows": Estimate(float(arm.bus.held_rows), 0.0),
            "of_commands": Estimate(0.0, 0.0),
        }
    return values


def _gross_sizes(arm: ArmModel, joint: int) -> Array:
    series = arm.problem.series[joint]
    return (series.predicted(arm.joints[joint].fit.p) - series.measured)[arm.gross[joint]]


def _of_joint(arm: ArmModel, model: JointModel) -> list[MotionCause]:
    series = arm.problem.series[model.joint]
    std = deviations(series, model) if model.forms else {}
    out = []
    for effect in model.effects:
        slots = [slot for form in model.forms if form.effect == effect for slot in form.slots]
        values = {}
        for slot in slots:
            one = std.get(slot.slot)
            values[slot.parameter] = Estimate(
                float(model.fit.p[INDEX[slot.slot]] * slot.factor), None if one is None else one * slot.factor
            )
        if "sine_rad" in values:  # as its injector takes it
            sine, cosine = values.pop("sine_rad"), values.pop("cosine_rad")
            spread = None if sine.std is None or cosine.std is None else float(np.hypot(sine.std, cosine.std))
            values["amplitude_rad"] = Estimate(float(np.hypot(sine.value, cosine.value)), spread)
            values["phase_rad"] = Estimate(float(np.arctan2(cosine.value, sine.value)), None)
        if effect == "contact":
            high = any(slot.slot == "stop_high_rad" for slot in slots)
            values["side"] = Estimate(1.0 if high else -1.0, None)
        less = without(series, model, effect)
        used = series.used
        gain = series.gain(less.fit.e, model.fit.e)
        squares = float((less.fit.e[used] ** 2).sum())
        share = 100.0 * (1.0 - float((model.fit.e[used] ** 2).sum()) / squares) if squares else 0.0
        ties = tuple(other for one, other in model.equivalents if one == effect)
        p_value = float(chi2.sf(max(gain, 0.0), len(slots)))
        out.append(MotionCause(effect, model.joint + 1, values, ties, p_value, max(share, 0.0)))
    return out


def _shared_percent(models: list[JointModel], arm: ArmModel) -> float:
    """Return the share of the squares that the models of all joints take away."""
    before = sum(float((_as_asked(arm, m) ** 2).sum()) for m in models)
    after = sum(float((m.fit.e[arm.problem.series[m.joint].used] ** 2).sum()) for m in models)
    return 100.0 * (1.0 - after / before) if before else 0.0


def _as_asked(arm: ArmModel, model: JointModel) -> Array:
    """(N,) remainder of the geometric twin that hears every command, in time."""
    sent = np.ascontiguousarray(arm.problem.recording.q_cmd[:, model.joint])
    p = model.geometric.p if arm.late is None else arm.late.off(model.geometric.p)
    return replace(arm.problem.series[model.joint], sent=sent).remainder(p)
