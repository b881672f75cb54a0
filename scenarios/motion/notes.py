"""What a moving recording cannot tell, and what was taken for what: one line each."""

from __future__ import annotations

import numpy as np

from armtwin.calib.motion.diagnosis import Estimate, MotionDiagnosis
from armtwin.calib.motion.experiment import NOT_FOLLOWED
from armtwin.scenarios.motion.rubbing import in_the_way, rubbing
from armtwin.scenarios.motion.words import parameter_words

# Moves below this are no moves.
_STILL_RAD = 1e-3
# Delays of so many joints tell an order, where it is beyond so many deviations; none is known better than this.
_LEAST_IN_TURN, _PLAINLY, _LEAST_STD_S = 3, 4.0, 2e-4
_WORDS = "delay, lag or friction"


def notes(found: MotionDiagnosis) -> list[str]:
    """Say what this recording cannot tell, and what was taken for what."""
    recording = found.recording
    told = [*rubbing(found), *in_the_way(found), *_clocks(found), *_ties(found), *_moves(found)]
    if any(one.differs for one in found.by_motion):
        told.append(in_every_motion(found))
    told += _left(found)
    if not found.problem.has_load:
        told.append("The arm's masses are not known: what grows with the load cannot be looked for.")
    grains = found.problem.grains_rad
    if grains.any():
        steps = ", ".join(f"{np.degrees(g):.3g}°" for g in sorted(set(np.round(grains[grains > 0], 6))))
        told.append(f"Readings come in steps of {steps}; a step/√12 is the floor of their noise.")
    missing = int(np.isnan(recording.q_meas).any(axis=1).sum())
    if missing:
        told.append(f"{missing} rows lack a measured angle; they are passed over.")
    return told


def _left(found: MotionDiagnosis) -> list[str]:
    """Say which joints the extended twin does not follow through the held-out motions."""
    out = [
        (one.after_rms_rad / one.noise_floor_rad, one)
        for one in found.held_out
        if one.joint not in found.loud and one.after_rms_rad > NOT_FOLLOWED * one.noise_floor_rad
    ]
    if not out:
        return []
    times, worst = max(out, key=lambda pair: pair[0])
    names = ", ".join(dict.fromkeys(found.recording.joint_names[one.joint] for _, one in out))
    return [
        f"On held-out motions the extended twin leaves more than {NOT_FOLLOWED:g} times the noise at {names}, at worst "
        f"{times:.0f} times ({found.recording.joint_names[worst.joint]} in {worst.trajectory}): what was named there "
        "is not all, or not it."
    ]


def _clocks(found: MotionDiagnosis) -> list[str]:
    told = []
    if found.recording.clock == "synthetic":
        told.append(
            "Times were made from row numbers and a nominal rate: a delay in seconds is as true as the rate stated."
        )
    if any(cause.effect == "latency" for cause in found.causes):
        told.append(
            "A late command and a late clock of the readings look the same: the delay is the sum of both, and of a "
            "joint that is read later than the others less by as much."
        )
        told += _read_in_turn(found)
    return told


def _read_in_turn(found: MotionDiagnosis) -> list[str]:
    """Say where delays fall from joint to joint: the joints are read one after the other."""
    known = [(c.joint, c.parameters["delay_s"]) for c in found.causes if c.effect == "latency" and c.joint is not None]
    known = [(joint, delay) for joint, delay in known if delay.std]
    if len(known) < _LEAST_IN_TURN:
        return []
    joints, delays = np.array([j for j, _ in known], dtype=float), np.array([d.value for _, d in known])
    weights = 1.0 / np.array([max(float(d.std or 0.0), _LEAST_STD_S) for _, d in known])
    (slope, _), covariance = np.polyfit(joints, delays, 1, w=weights, cov="unscaled")
    if slope > -_PLAINLY * float(np.sqrt(covariance[0, 0])):
        return []
    return [
        f"The delay falls by {-1e3 * slope:.2g} ms from joint to joint: they are read one after the other, each later "
        "in its cycle; the offset of a joint's reading is one with its latency."
    ]


def in_every_motion(found: MotionDiagnosis) -> str:
    """Say whether delay, lag and friction are one number over all motions, or which are not."""
    others = [one for one in found.by_motion if one.differs]
    if not found.by_motion:
        return "No delay, lag or friction was named that could be asked of each motion alone."
    if not others:
        return "Delay, lag and friction are the same in every motion, as far as each can tell alone."
    told = []
    for joint, parameter in dict.fromkeys((one.joint, one.parameter) for one in others):
        own = [one for one in found.by_motion if (one.joint, one.parameter) == (joint, parameter)]
        low, high = min(own, key=lambda one: one.value), max(own, key=lambda one: one.value)
        values = [parameter_words(parameter, Estimate(one.value, None))[0] for one in (low, high)]
        name = found.recording.joint_names[joint]
        told.append(f"{parameter} of {name} is {values[0]} in {low.motion} and {values[1]} in {high.motion}")
    return (
        f"Not one number over all motions: {'; '.join(told)}. What changes with the motion is no {_WORDS} alone: "
        "something else looks like it."
    )


def _ties(found: MotionDiagnosis) -> list[str]:
    if not any(cause.effect == "friction" for cause in found.causes):
        return []
    return [
        "At one P gain and one load a band of friction looks like play behind an encoder on the motor's side; it "
        "is called friction where its size follows the drive or the load, or where the servo's answer rounds."
    ]


def _moves(found: MotionDiagnosis) -> list[str]:
    recording, told = found.recording, []
    joints = range(recording.n_joints)
    unsaid = [j for j in joints if not found.problem.moves(j) and j not in found.loud]
    still = [j for j in unsaid if not np.ptp(recording.q_cmd[found.problem.fitted, j]) > _STILL_RAD]
    if still:
        told.append(f"{_joints(still)} got no commands to move: nothing is said of {_them(still)}.")
    stuck = [j for j in unsaid if j not in still]
    if stuck:
        told.append(
            f"{_joints(stuck)} never moved while commanded to, or {'were' if len(stuck) > 1 else 'was'} hardly ever "
            f"read: a servo without power, or a reading that is stuck; nothing is said of {_them(stuck)}."
        )
    one_way = [j for j in joints if found.problem.moves(j) and not found.problem.series[j].turns_back]
    if one_way:
        told.append(
            f"{_joints(one_way)} never turned back: play, hysteresis and dry friction there are one with the joint's "
            "zero; add the same motion backwards."
        )
    return told


def _joints(numbers: list[int]) -> str:
    return f"Joint{'s' if len(numbers) > 1 else ''} {', '.join(str(j + 1) for j in numbers)}"


def _them(numbers: list[int]) -> str:
    return "them" if len(numbers) > 1 else "it"
