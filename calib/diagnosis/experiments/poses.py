"""Candidate plans, by the names under which effects ask for them (`Effect.plans`)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from armtwin.models.catalogue.context import Context
from armtwin.models.plan import MAX_STEP_RAD, steps_between

Array = NDArray[np.float64]

# Beyond the joint angles that the recording has visited, a tenth of their range is taken to be safe, and at least 3
# degrees, so that a joint that was held still can be moved at all.
_MARGIN_SHARE = 0.1
_LEAST_MARGIN_RAD = 0.05
# Steps after a reversal: from below a good servo's play to beyond a bad one's.
_FINEST_STEP_RAD = 0.002
_POSES = 24
# A mass that a hobby servo holds at arm's length, and that shows.
PAYLOAD_KG = 0.1


@dataclass(frozen=True, eq=False)
class CandidatePlan:
    """Poses that may be run after a recording: (K, n) commands, (K,) payload, and what a person has to do."""

    name: str
    q_cmd: Array
    payload_kg: Array
    what: str
    instructions: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class Space:
    """Where an arm may go: its context and (n, 2) lowest and highest command of each joint."""

    context: Context
    ranges: Array

    @property
    def rest(self) -> Array:
        """(n,) the middle of what the recording visited."""
        return np.asarray(np.median(self.context.q_cmd, axis=0))


def space_of(context: Context) -> Space:
    """Return the joint ranges of a recording with a sensible margin."""
    low, high = context.q_cmd.min(axis=0), context.q_cmd.max(axis=0)
    margin = np.maximum(_MARGIN_SHARE * (high - low), _LEAST_MARGIN_RAD)
    return Space(context, np.stack([low - margin, high + margin], axis=-1))


def reversal(space: Space, joint: int) -> CandidatePlan:
    """Fine steps of one joint after each of six reversals, three from either side."""
    low, high = space.ranges[joint]
    steps = _FINEST_STEP_RAD * 1.7 ** np.arange(8)
    path: list[float] = []
    for share in (0.3, 0.5, 0.7):
        turn = low + share * (high - low)
        for side in (1.0, -1.0):
            reach = turn - side * 0.25 * (high - low)
            path += [reach, turn, *(turn - side * np.cumsum(steps))]
    what = f"joint {joint + 1} turns back at three places from either side and goes on in steps that grow"
    return _of_joint("reversal", space, joint, np.array(path), what)


def growing_steps(space: Space, joint: int) -> CandidatePlan:
    """Steps there and back of one joint, each larger than the one before."""
    low, high = space.ranges[joint]
    middle, reach = 0.5 * (low + high), min(0.95 * 0.5 * (high - low), 0.5 * MAX_STEP_RAD)
    sizes = np.geomspace(_FINEST_STEP_RAD, reach, 2 * _POSES)
    what = f"joint {joint + 1} steps there and back, every step larger than the one before"
    return _of_joint("growing_steps", space, joint, middle + sizes * (-1.0) ** np.arange(len(sizes)), what)


def fine_ramp(space: Space, joint: int) -> CandidatePlan:
    """A slow ramp of one joint in steps far below a degree, upwards and back."""
    low, high = space.ranges[joint]
    middle = 0.5 * (low + high)
    up = middle + 0.75 * _FINEST_STEP_RAD * np.arange(1.5 * _POSES)
    what = f"joint {joint + 1} creeps up and back in steps of {np.degrees(0.75 * _FINEST_STEP_RAD):.2f} degrees"
    return _of_joint("fine_ramp", space, joint, np.concatenate([up, up[::-1]]), what)


def full_sweep(space: Space, joint: int) -> CandidatePlan:
    """One joint over all of its range, there and back."""
    low, high = space.ranges[joint]
    up = np.linspace(low, high, _POSES)
    what = f"joint {joint + 1} sweeps its whole range, there and back"
    return _of_joint("full_sweep", space, joint, np.concatenate([up, up[::-1]]), what)


def stretched_and_folded(space: Space, joint: int) -> CandidatePlan:
    """Poses of the largest and of the smallest torque of gravity about a joint, by turns."""
    q = _scattered(space, 40 * _POSES)
    links, tip = space.context.masses_kg
    order = np.argsort(space.context.gravity_torque(q, links, np.array(tip))[:, joint])
    half = _POSES // 2
    picked = np.stack([order[:half], order[: -half - 1 : -1]], axis=-1).ravel()
    what = f"the arm is stretched and folded by turns, so that gravity's torque about joint {joint + 1} changes most"
    return CandidatePlan(f"stretched_and_folded_{joint + 1}", q[picked], np.zeros(len(picked)), what)


def known_payload(space: Space) -> CandidatePlan:
    """The same poses without and with a known mass at the tip."""
    q = _scattered(space, _POSES)
    payload = np.repeat([0.0, PAYLOAD_KG], len(q))
    grams = round(1000 * PAYLOAD_KG)
    what = f"the same poses without and with {grams} g at the tip"
    do = (f"hang {grams} g at the tip when the plan's column payload_kg says so",)
    return CandidatePlan("known_payload", np.concatenate([q, q]), payload, what, do)


def repeat_pose(space: Space) -> CandidatePlan:
    """One pose again and again, with others in between, so that only time can change what is seen."""
    away = _scattered(space, _POSES)
    q = np.stack([np.tile(space.rest, (len(away), 1)), away], axis=1).reshape(-1, away.shape[1])
    return CandidatePlan("repeat_pose", q, np.zeros(len(q)), "one pose is visited again and again between others")


def whole_picture(space: Space) -> CandidatePlan:
    """Every corner of the joints' ranges and poses between them: as much of the picture as the arm can reach."""
    corners = np.array(list(product(*space.ranges)))[: 2 * _POSES]
    q = np.concatenate([corners, _scattered(space, _POSES)])
    return CandidatePlan("whole_picture", q, np.zeros(len(q)), "the markers are brought to every part of the picture")


def camera_elsewhere(space: Space) -> CandidatePlan:
    """Scattered poses, to be seen from elsewhere by a camera that is calibrated anew."""
    q = _scattered(space, 2 * _POSES)
    do = (
        "move the camera so that it looks at the board from about 20 degrees to the side, and calibrate its place anew "
        "(armtwin calibrate-camera)",
        "run this plan as a recording of its own and diagnose it: a cause in the arm stays, one in the camera goes",
    )
    return in_small_steps(CandidatePlan("camera_elsewhere", q, np.zeros(len(q)), "the arm is seen from elsewhere", do))


def gauge_in_plane(space: Space) -> CandidatePlan:
    """The arm at rest, with a gauge of known length laid in its plane."""
    q = np.tile(space.rest, (4, 1))
    do = (
        "lay a gauge of known length in the arm's plane, at four places of the picture, one a pose",
        "measure its length in every picture: a wrong scale there is the camera's (focal_length, plane_offset), not "
        "the arm's",
    )
    return CandidatePlan("gauge_in_plane", q, np.zeros(len(q)), "a known length is seen in the arm's plane", do)


def calibrate_again(space: Space) -> CandidatePlan:
    """The arm at rest, and the camera's place calibrated once more by the board."""
    do = (
        "take new board views and calibrate the camera's place and lens anew, without touching it "
        "(armtwin calibrate-camera)",
        "compare with the calibration that the recording holds: a cause in the camera shows there, one in the arm does "
        "not; then record again with the new calibration",
    )
    return CandidatePlan(
        "calibrate_again", space.rest[None], np.zeros(1), "the camera is held against the board again", do
    )


_BY_JOINT: dict[str, Callable[[Space, int], CandidatePlan]] = {
    "reversal": reversal,
    "growing_steps": growing_steps,
    "fine_ramp": fine_ramp,
    "full_sweep": full_sweep,
    "stretched_and_folded": stretched_and_folded,
}
_BY_ARM: dict[str, Callable[[Space], CandidatePlan]] = {
    "known_payload": known_payload,
    "repeat_pose": repeat_pose,
    "whole_picture": whole_picture,
}
# What has to be done by a person and cannot be appended to the recording.
BY_HAND: dict[str, Callable[[Space], CandidatePlan]] = {
    "calibrate_again": calibrate_again,
    "gauge_in_plane": gauge_in_plane,
    "camera_elsewhere": camera_elsewhere,
}
_NEED_GRAVITY = ("stretched_and_folded", "known_payload")
_NEED_CAMERA = ("whole_picture",)
NAMES: tuple[str, ...] = (*_BY_JOINT, *_BY_ARM, *BY_HAND)


def candidates(space: Space, joints: tuple[int, ...]) -> list[CandidatePlan]:
    """List the plans that can be run on the bench as it stands; `joints` (from 0) are those in question."""
    context = space.context
    out_of_question = (*(() if context.has_gravity else _NEED_GRAVITY), *(() if context.camera else _NEED_CAMERA))
    usable = [name for name in (*_BY_JOINT, *_BY_ARM) if name not in out_of_question]
    found = [_BY_JOINT[name](space, joint) for name in usable if name in _BY_JOINT for joint in joints]
    found += [_BY_ARM[name](space) for name in usable if name in _BY_ARM]
    return [in_small_steps(candidate) for candidate in found]


def in_small_steps(candidate: CandidatePlan) -> CandidatePlan:
    """Put poses between those that are further apart than a bench allows in one step; they are recorded like others."""
    q, payload = [candidate.q_cmd[:1]], [candidate.payload_kg[:1]]
    for row in range(1, len(candidate.q_cmd)):
        steps = steps_between(candidate.q_cmd[row - 1], candidate.q_cmd[row], MAX_STEP_RAD)
        q.append(steps)
        payload.append(np.full(len(steps), candidate.payload_kg[row]))
    return replace(candidate, q_cmd=np.concatenate(q), payload_kg=np.concatenate(payload))


def _of_joint(name: str, space: Space, joint: int, path: Array, what: str) -> CandidatePlan:
    """The joint goes along `path` (K,), kept inside its range; the others rest."""
    q = np.tile(space.rest, (len(path), 1))
    q[:, joint] = np.clip(path, *space.ranges[joint])
    return CandidatePlan(f"{name}_{joint + 1}", q, np.zeros(len(path)), what)


def _scattered(space: Space, n: int) -> Array:
    """(n, joints) poses that fill the ranges evenly: an additive recurrence (M. Roberts' R sequence)."""
    d = len(space.ranges)
    g = 2.0
    for _ in range(40):  # the positive root of g^(d+1) = g + 1, by fixed point
        g = (1.0 + g) ** (1.0 / (d + 1))
    unit = np.mod(0.5 + np.outer(np.arange(1, n + 1), g ** -np.arange(1.0, d + 1)), 1.0)
    low, high = space.ranges.T
    out: Array = low + unit * (high - low)
    return out
