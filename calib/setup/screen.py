"""The screen: which gross errors of the set-up a recording plainly has, one after the other."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import permutations

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.setup.hypotheses import OUT_OF_STEP, SetUpError, hypotheses
from armtwin.calib.setup.remainder import Remainder, remainder_of
from armtwin.models.recordings.recording import Recording

Array = NDArray[np.float64]

# Only what is gross is a matter of the set-up; what a part that still works does wrong is seldom more in the median.
_GROSS_RAD = np.radians(3.0)
_GROSS_MM = 3.0
# Below these a channel is as right as can be told here.
_FINE_RAD = np.radians(0.5)
_FINE_MM = 0.5
# A wrong set-up leaves many times what the right one does, on the poses that it was judged by and on others.
_BETTER = 4.0
# Whole turns may be rare: they are judged by the rows in which they happen.
_TURNS = ("whole_turns", "half_turns")
_LEAST_OTHERS = 3
# Hypotheses whose remainders differ by less than this cannot be told apart.
_ALIKE = 1.5
_MOST_ERRORS = 4
_EVERY = 3
# Of fewer nothing can be judged on some and held against the others.
_LEAST_POSES = 2 * _EVERY
# Zeros beyond this are off by a quarter turn or a half one, not by a spline's tooth.
_ZERO_RAD = np.radians(60.0)
_NEAR_RAD = np.radians(20.0)
# Lengths that are off by this are another link's; they are one another's where that leaves less than a third.
_LENGTH_OFF_MM = 10.0
_MOST_ORDERED = 6


@dataclass(frozen=True, eq=False)
class Screened:
    """A recording without the errors that were found, these, and what each could also be."""

    recording: Recording
    errors: tuple[SetUpError, ...]
    ties: tuple[tuple[SetUpError, ...], ...]

    @property
    def sentences(self) -> list[str]:
        """One line an error: what is wrong, what else it could be, and what to do."""
        lines = []
        for error, others in zip(self.errors, self.ties, strict=True):
            tie = "".join(f", or {other.said}" for other in others)
            lines.append(f"{error.said}{tie}: {error.remedy}")
        return lines


def screen(recording: Recording) -> Screened:
    """Return a recording mended of its gross errors; of most recordings nothing is found."""
    if len(recording) <= _LEAST_POSES or not _measured(recording):
        return Screened(recording, (), ())
    errors: list[SetUpError] = []
    ties: list[tuple[SetUpError, ...]] = []
    while len(errors) < _MOST_ERRORS:
        best = _best(recording, remainder_of(recording))
        if best is None:
            break
        errors.append(best[0])
        ties.append(best[1])
        recording = best[0].mend(recording)
    for look in (_zeros, _lengths):
        error = look(recording, remainder_of(recording))
        if error is not None:
            errors.append(error)
            ties.append(())
            recording = error.mend(recording)
    return Screened(recording, tuple(errors), tuple(ties))


def _measured(recording: Recording) -> bool:
    seen = [*recording.markers_px.values(), *([] if recording.q_meas is None else [recording.q_meas])]
    return any(np.isfinite(values).any() for values in seen)


def _best(recording: Recording, found: Remainder) -> tuple[SetUpError, tuple[SetUpError, ...]] | None:
    """Return the error without which least is left, where that is far less, and those that leave as little."""
    gross, fine = (_GROSS_MM, _FINE_MM) if recording.markers_px else (_GROSS_RAD, _FINE_RAD)
    judged = np.arange(len(recording)) % _EVERY != 0
    every = np.ones(len(recording), dtype=bool)
    scored: list[tuple[float, SetUpError]] = []
    turned: tuple[float, SetUpError] | None = None
    for error in hypotheses(recording, found):
        left = remainder_of(error.mend(recording))
        if error.error in _TURNS:
            if turned is None and _turns_are_plain(found, left, error.joints[0] - 1):
                turned = (_gain(found.spreads(every), left.spreads(every), 0.0, fine), error)
            continue
        gains = [_gain(found.spreads(rows), left.spreads(rows), gross, fine) for rows in (judged, ~judged)]
        off = _off_the_drawing(recording, left)
        if min(gains) - max(off - _off_the_drawing(recording, found), 0.0) > np.log(_BETTER):
            scored.append((min(gains) - off, error))
    scored.sort(key=lambda pair: -pair[0])
    if turned is not None and (not scored or scored[0][0] < turned[0] + np.log(_BETTER)):
        return turned[1], ()  # turns may be rare and change no median
    if not scored or scored[0][1].error == OUT_OF_STEP:
        return None
    most = scored[0][0]
    scored = [pair for pair in scored if pair[1].error != OUT_OF_STEP]
    return scored[0][1], tuple(error for gain, error in scored[1:] if gain > most - np.log(_ALIKE))


def _gain(before: Array, after: Array, gross: float, fine: float) -> float:
    """Return by how much the logarithms of the channels' spreads fall; nothing where none is gross, or one grows so."""
    if before.max() < gross or (after > np.maximum(_ALIKE * before, gross)).any():
        return 0.0
    return float(np.log(np.maximum(before, fine)).sum() - np.log(np.maximum(after, fine)).sum())


def _off_the_drawing(recording: Recording, left: Remainder) -> float:
    """Return the cost of zeros that no horn is off by, where the drawing says where zero is."""
    if not recording.arm.form.zero_is_drawn:
        return 0.0
    return float((np.minimum(np.abs(left.zeros_rad) / _ZERO_RAD, 2.0) ** 2).sum())


def _turns_are_plain(found: Remainder, left: Remainder, joint: int) -> bool:
    """Whether the rows that were turned back now lie among the others, and all of these lie near together."""
    moved = np.flatnonzero(np.abs(found.errors[:, joint] - left.errors[:, joint]) > 1.0)
    others = np.setdiff1d(np.arange(len(left.errors)), moved)
    if not len(moved) or len(others) < _LEAST_OTHERS:
        return False  # all of them: that is the zero
    usual = np.nanquantile(left.errors[others, joint], 0.95)
    return bool(usual < 0.5 and np.nanmedian(left.errors[moved, joint]) < max(3.0 * usual, 0.02))


def _zeros(recording: Recording, found: Remainder) -> SetUpError | None:
    """Return joints whose zero is off by quarter or half turns, where the drawing says where zero is."""
    if recording.markers_px and not recording.arm.form.zero_is_drawn:
        return None  # the zero pose of such an arm is not stated
    quarters = np.round(found.zeros_rad / (np.pi / 2.0))
    near = np.abs(found.zeros_rad - quarters * np.pi / 2.0) < _NEAR_RAD
    off = np.flatnonzero((np.abs(found.zeros_rad) > _ZERO_RAD) & near & (quarters != 0))
    if not len(off):
        return None
    shift = np.zeros(recording.arm.n_joints)
    shift[off] = quarters[off] * np.pi / 2.0
    which = ", ".join(f"joint {joint + 1} by {90 * quarters[joint]:.0f} degrees" for joint in off)

    def mend(wrong: Recording) -> Recording:
        return replace(wrong, q_cmd=wrong.q_cmd + shift)

    return SetUpError(
        "zero_off",
        tuple(int(joint) + 1 for joint in off),
        f"zeros are off by quarter turns: {which}",
        "put the horn on again, or add these angles to the commands",
        mend,
    )


def _lengths(recording: Recording, found: Remainder) -> SetUpError | None:
    """Return link lengths that stand in the wrong order, by what the poses say of each link."""
    arm = recording.arm
    n = arm.n_joints
    if not recording.markers_px or not 2 <= n <= _MOST_ORDERED or len(arm.link_lengths_mm) != n:
        return None
    seen = np.abs(found.links) * arm.link_lengths_mm
    moving = np.ptp(recording.q_cmd, axis=0) > 1e-6
    if not moving.all() or np.abs(seen - arm.link_lengths_mm).max() < _LENGTH_OFF_MM:
        return None

    def off(order: tuple[int, ...]) -> float:
        return float(np.abs(seen - arm.link_lengths_mm[list(order)]).max())

    best = min(permutations(range(n)), key=off)
    if off(best) * 3.0 > off(tuple(range(n))):
        return None
    lengths = arm.link_lengths_mm[list(best)]

    def mend(wrong: Recording) -> Recording:
        return replace(wrong, arm=replace(wrong.arm, link_lengths_mm=lengths))

    return SetUpError(
        "link_lengths_out_of_order",
        (),
        "the link lengths stand in the wrong order",
        f"write link_lengths_mm from the base to the tip: {', '.join(f'{length:g}' for length in lengths)}",
        mend,
    )
