"""A marker that left its command for good: a slipped horn turns all beyond it by one angle, in every picture from then.

In one picture a disc at a link's distance that the command does not expect may be anything red. In many pictures the
arm's own disc keeps its angle to the command, and nothing else does.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.markers.disc import Disc
from armtwin.calib.markers.reading import MarkerReading
from armtwin.models.arm import Arm
from armtwin.models.camera import Camera, back_project
from armtwin.models.coordinate_frames import board_to_robot
from armtwin.models.kinematics import marker_positions, wrap

Array = NDArray[np.float64]

# Pictures that must agree, and the share of those in which the marker is missing.
_LEAST_PICTURES, _LEAST_SHARE = 5, 0.6
# Two standard deviations of a joint that does follow its command, with play and an uncalibrated zero.
_AGREE_RAD = np.deg2rad(6.0)
# Below it the command still finds the marker.
_LEAST_SLIP_RAD = np.deg2rad(15.0)
# What a link may be off in length, as a share.
_LENGTH_SHARE = 0.12


def slipped_commands(
    found: Sequence[tuple[Disc, ...]],
    readings: Sequence[MarkerReading],
    arm: Arm,
    camera: Camera,
    plane_z_mm: float,
    q_cmd: Array,
) -> dict[int, Array]:
    """Return, for rows in which a marker is missing, (n,) commands turned by what the marker's link has slipped by.

    Empty where no turn is shared by enough pictures.
    """
    corrected: dict[int, Array] = {}
    places = [board_to_robot(_places(discs, camera, plane_z_mm), np.zeros(3))[:, :2] for discs in found]
    expected = marker_positions(arm, q_cmd)
    names = arm.marker_names
    for joint in range(arm.n_joints):
        origins = [_origin(places[k], found[k], one, joint, arm, expected[k]) for k, one in enumerate(readings)]
        missing = [one.status[names[joint + 1]] != "seen" for one in readings]
        rows = [k for k, origin in enumerate(origins) if origin is not None and missing[k]]
        if len(rows) < _LEAST_PICTURES:
            continue
        turns = [_turns(places[k], int(origins[k] or 0), joint, expected[k]) for k in rows]
        shared = _shared(turns)
        if shared is None or abs(shared) < _LEAST_SLIP_RAD:
            continue
        offered = dict(zip(rows, turns, strict=True))
        for row in np.flatnonzero(missing).tolist():
            # A picture whose naming was open altogether offers nothing; the turned command may settle it.
            if row not in offered or (np.abs(wrap(offered[row] - shared)) < _AGREE_RAD).any():
                corrected[row] = q_cmd[row].copy()
                corrected[row][joint] += shared
        break  # all beyond it turns along
    return corrected


def _origin(
    places: Array, discs: tuple[Disc, ...], reading: MarkerReading, joint: int, arm: Arm, expected: Array
) -> int | None:
    """Return the disc on a joint's axis: the one seen there, or where the last marker seen before it expects one."""
    seen = [k for k in range(joint + 1) if arm.marker_names[k] in reading.discs]
    if not seen:
        return None
    at = next(k for k, disc in enumerate(discs) if disc is reading.discs[arm.marker_names[seen[-1]]])
    if seen[-1] == joint:
        return at
    way = expected[joint] - expected[seen[-1]]
    off = np.hypot(*(places - places[at] - way).T)
    nearest = int(np.nanargmin(off))
    return nearest if off[nearest] < _LENGTH_SHARE * float(np.hypot(*way)) and nearest != at else None


def _turns(places: Array, origin: int, joint: int, expected: Array) -> Array:
    """(k,) turns against the command by which each disc at the link's distance would be the marker, rad."""
    link = expected[joint + 1] - expected[joint]
    length = float(np.hypot(*link))
    way = places - places[origin]
    near = np.abs(np.hypot(*way.T) - length) < _LENGTH_SHARE * length
    near[origin] = False
    turns: Array = wrap(np.arctan2(way[near, 1], way[near, 0]) - np.arctan2(link[1], link[0]))
    return turns


def _shared(turns: Sequence[Array]) -> float | None:
    """Return the turn that most pictures offer, or None."""
    everything = np.concatenate([*turns, np.empty(0)])
    if not len(everything):
        return None
    counts = [sum(len(t) > 0 and np.abs(wrap(t - turn)).min() < _AGREE_RAD for t in turns) for turn in everything]
    most = int(np.max(counts))
    if most < max(_LEAST_PICTURES, _LEAST_SHARE * len(turns)):
        return None
    best = everything[int(np.argmax(counts))]
    close = wrap(everything - best)
    return float(wrap(best + np.median(close[np.abs(close) < _AGREE_RAD])))


def _places(discs: tuple[Disc, ...], camera: Camera, plane_z_mm: float) -> Array:
    return back_project(camera, np.array([disc.centre for disc in discs]).reshape(-1, 2), plane_z_mm)
