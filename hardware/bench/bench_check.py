"""Is the bench wired as its file says? Each joint is moved a little, and the picture tells which one turned how far.

commanded   joint 1  +0.10 rad
seen        joint 1  -0.10    joint 2  0.00    joint 3  0.00     ->  joint 1 turns the wrong way round
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armtwin.hardware.bench.bench_file import BenchSetup
from armtwin.hardware.bench.hardware_bench import HardwareBench
from armtwin.models.errors import JobError

Array = NDArray[np.float64]

# About 6 degrees: 12 mm at the tip by joint 1, 4 mm by joint 3, far above a servo's dead band and the camera's noise.
PROBE_RAD = 0.1
# Shares of the commanded turn: below the first a joint stands, beyond the others its scale is off.
_STANDS = 0.25
_SCALE_LOW, _SCALE_HIGH = 0.8, 1.25
# A joint this far from its command needs its horn or its zero_us set; smaller offsets are what calibration finds.
_ZERO_OFF_RAD = np.deg2rad(10.0)


@dataclass(frozen=True)
class Finding:
    """One line of the check: whether it is well, and what was found (and what to do)."""

    good: bool
    text: str


def run_bench_check(bench: HardwareBench, report: Callable[[str], None] | None = None) -> list[Finding]:
    """Arm a connected bench in its rest pose, move each joint to and fro, and judge; raises `JobError`.

    The picture is not used to find where to arm, since with a wrong servo map the arm would jump: a person has put it
    into the rest pose. Nobody puts it there to the degree, so it is looked at only once arming has moved it.
    """
    setup = bench.setup
    rest = setup.rest_rad
    bench.arm_at(rest)
    seen_at_rest = _posture(bench, "at rest")
    turn = min(PROBE_RAD, setup.limits.max_step_rad)
    turned = np.zeros((len(rest), len(rest)))
    for joint in range(len(rest)):
        if report is not None:
            report(f"moving joint {joint + 1}")
        probe = np.zeros_like(rest)
        probe[joint] = turn if rest[joint] + turn <= setup.limits.max_rad[joint] else -turn
        bench.move(rest + probe)
        out = _posture(bench, f"after joint {joint + 1} moved")
        bench.move(rest)
        back = _posture(bench, f"after joint {joint + 1} moved back")
        turned[joint] = (out - 0.5 * (seen_at_rest + back)) / probe[joint]
    findings = [judge_joint(setup, joint, turned[joint]) for joint in range(len(rest))]
    return findings + judge_zeros(setup, seen_at_rest)


def judge_joint(setup: BenchSetup, joint: int, shares: Array) -> Finding:
    """Judge the (n,) turns that were seen, as shares of the turn that joint `joint` (from 0) was commanded."""
    name = f"joint {joint + 1}"
    mover = int(np.argmax(np.abs(shares)))
    share = float(shares[mover])
    if abs(share) < _STANDS:
        return Finding(False, f"{name} does not move: check its plug, its supply and [[joints]] servo")
    if mover != joint:
        return Finding(
            False,
            f"{name} turns joint {mover + 1} instead: exchange their plugs, or the servo numbers in [[joints]]",
        )
    if share < 0:
        wanted = -int(np.sign(setup.servo_map.us_per_rad[joint]))
        return Finding(False, f"{name} turns the wrong way: set its direction = {wanted}")
    if not _SCALE_LOW <= share <= _SCALE_HIGH:
        slope = abs(setup.servo_map.us_per_rad[joint]) / share
        return Finding(False, f"{name} turns {share:.2f} times what is commanded: set its us_per_rad = {slope:.0f}")
    others = np.delete(np.abs(shares), joint)
    if others.max() > _STANDS:
        return Finding(False, f"{name} drags another joint along: tighten the horns, check the markers")
    return Finding(True, f"{name} turns the right way, {share:.2f} of what is commanded")


def judge_zeros(setup: BenchSetup, seen: Array) -> list[Finding]:
    """Judge the (n,) angles, rad, that the picture shows where the rest pose was commanded."""
    findings = []
    for joint, off in enumerate(seen - setup.rest_rad):
        if abs(off) > _ZERO_OFF_RAD:
            zero = setup.servo_map.zero_us[joint] - off * setup.servo_map.us_per_rad[joint]
            findings.append(
                Finding(
                    False,
                    f"joint {joint + 1} stands {np.degrees(off):+.0f} deg from its command: put the horn on another "
                    f"tooth, or set its zero_us = {zero:.0f}",
                )
            )
    return findings or [
        Finding(True, f"zeros are within {np.degrees(_ZERO_OFF_RAD):.0f} deg; calibration does the rest")
    ]


def _posture(bench: HardwareBench, when: str) -> Array:
    seen = bench.posture()
    if seen is None:
        raise JobError(
            f"bench check: not all markers {', '.join(bench.setup.arm.marker_names)} are seen {when}; light them "
            "evenly, keep cables off them, and check that each stands on its axis"
        )
    return seen
