"""A moving arm's diagnosis in sentences, for the terminal and the report."""

from __future__ import annotations

from typing import Any

import numpy as np

from armtwin.calib.motion.diagnosis import Estimate, MotionCause, MotionDiagnosis
from armtwin.calib.motion.experiment import NextMotion
from armtwin.models.catalogue.motion_effect import motion_effect_named
from armtwin.models.statistics import Z95
from armtwin.scenarios.motion.resimulate import Resimulated

# The motions of the proposed experiment, as a plan with times that `capture --film` executes.
NEXT_PLAN = "next_experiment.csv"


def where(found: MotionDiagnosis, cause: MotionCause) -> str:
    """Return the joint by number and name, or 'whole arm'."""
    if cause.joint is None:
        return "whole arm"
    name = found.recording.joint_names[cause.joint - 1]
    return f"joint {cause.joint}" if name == f"joint {cause.joint}" else f"joint {cause.joint} ({name})"


def label(found: MotionDiagnosis, cause: MotionCause) -> str:
    """Return a cause's name with its place."""
    return f"{cause.effect} ({where(found, cause)})"


def headline(found: MotionDiagnosis) -> str:
    """Return the verdict in one sentence."""
    named = by_joint(found)
    if found.verdict == "none":
        return "Nothing is wrong beyond the noise: the nominal servo moves as the recording says."
    if found.verdict == "named":
        return f"The cause{'s are' if len(found.causes) > 1 else ' is'} {named}."
    if found.verdict == "ambiguous":
        tied = [cause for cause in found.causes if cause.equivalents]
        ties = "; ".join(f"{label(found, cause)} from {' or '.join(cause.equivalents)}" for cause in tied)
        sure = [label(found, cause) for cause in found.causes if not cause.equivalents]
        return f"These motions cannot tell {ties}" + (f"; besides, {', '.join(sure)}." if sure else ".")
    joints = ", ".join(str(joint + 1) for joint in found.loud)
    at = f"joint{'s' if len(found.loud) > 1 else ''} {joints}"
    text = f"What remains at {at} is more than the noise, and no known effect explains it"
    return text + (f"; found besides: {named}." if named else ".")


def by_joint(found: MotionDiagnosis) -> str:
    """Return all causes, joint by joint, the most explaining of each first."""
    places: dict[str, list[str]] = {}
    for cause in sorted(found.causes, key=lambda one: (one.joint or 0, -one.explained_percent)):
        places.setdefault(where(found, cause), []).append(cause.effect)
    return "; ".join(f"{' and '.join(names)} ({place})" for place, names in places.items())


def gain(found: MotionDiagnosis) -> str:
    """Return what naming the causes gained on motions that nothing was fitted to."""
    if not found.held_out:
        return "No motion was held out."
    rms = [
        np.sqrt(np.mean([getattr(one, key) ** 2 for one in found.held_out]))
        for key in ("command_rms_rad", "nominal_rms_rad", "before_rms_rad", "after_rms_rad", "noise_floor_rad")
    ]
    command, nominal, before, after, floor = (f"{1e3 * value:.3g}" for value in rms)
    names = ", ".join(dict.fromkeys(one.trajectory for one in found.held_out))
    text = (
        f"On {names}, which nothing was fitted to, the joints are off by {command} mrad from their commands, "
        f"{nominal} by the nominal servo, {before} with the zeros fitted and {after} by the extended twin; "
        f"the noise is {floor} mrad"
    )
    if not found.causes:
        return f"{text}."
    interval = f"95 % interval {found.gain.low:.1f} to {found.gain.high:.1f} %"
    return f"{text}. That is {found.gain.percent:.1f} % less ({interval})."


def missed(found: MotionDiagnosis, again: Resimulated | None) -> str:
    """Return how far the re-simulated twin is from the held-out motions, in one sentence."""
    if again is None:
        return "The twin was not re-simulated in MuJoCo: no held-out motion is whole, or a joint is not explained."
    total = float(np.sqrt(np.mean(again.rms_rad**2)))
    without = f", without {' and '.join(again.left_out)}," if again.left_out else ""
    return (
        f"Re-simulated in MuJoCo{without} the extended twin misses the held-out motions by {1e3 * total:.3g} mrad RMS."
    )


def parameter_words(name: str, one: Estimate) -> tuple[str, str]:
    """Return a parameter's value, and its 95 % interval in the unit that a person reads."""
    unit = "°" if name.endswith("_rad") else " ms" if name in ("delay_s", "time_constant_s") else ""
    factor = {"°": 180.0 / np.pi, " ms": 1e3, "": 1.0}[unit]
    if name == "side":
        return ("stops growing angles" if one.value > 0 else "stops falling angles"), "–"
    value = f"{one.value * factor:.3g}{unit} ({one.value:.4g})" if unit else f"{one.value:.4g}"
    if one.std is None:
        return value, "–"
    low, high = factor * (one.value - Z95 * one.std), factor * (one.value + Z95 * one.std)
    return value, f"{low:.3g} to {high:.3g}{unit}"


def next_table(proposed: NextMotion | None) -> dict[str, Any] | None:
    """Return the proposed motions as data, or None where none are needed."""
    if proposed is None:
        return None
    return {"trajectory": proposed.trajectory, "tells_apart": list(proposed.tells_apart), "why": proposed.why}


def ties(found: MotionDiagnosis) -> list[tuple[str, str, str]]:
    """List what each cause looks like, and the motion that tells them apart: cause with its places, others, motion."""
    places: dict[str, list[str]] = {}
    for cause in sorted(found.causes, key=lambda one: (one.joint or 0, -one.explained_percent)):
        places.setdefault(cause.effect, []).append(where(found, cause))
    effects = [(motion_effect_named(name), at) for name, at in places.items()]
    return [
        (f"{effect.name} ({', '.join(at)})", " or ".join(effect.confused_with), effect.experiment)
        for effect, at in effects
        if effect.confused_with
    ]


def what_next(found: MotionDiagnosis, proposed: NextMotion | None) -> str:
    """Return what to do now."""
    if proposed is not None:
        assert proposed.plan.time_s is not None
        joints = ", ".join(map(str, proposed.joints))
        return (
            f"Record next ({NEXT_PLAN}, {proposed.plan.time_s[-1]:.0f} s): {proposed.trajectory}; "
            f"for joint{'s' if len(proposed.joints) > 1 else ''} {joints}: {proposed.why}."
        )
    if found.verdict == "none":
        return "Use the nominal servo as it is."
    return "Use twin.toml: it is the arm with these causes in it."
