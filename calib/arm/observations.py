"""What a recording shows of the arm: every seen marker as one observation, and the refusal of too few of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.arm.chain import Chain, ComplexArray
from armtwin.models.arm import Arm
from armtwin.models.errors import InputError, nearest
from armtwin.models.recordings.recording import Recording

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Observations:
    """K seen markers.

    Attributes:
        row: (K,) row of the recording.
        marker: (K,) number into `markers`.
        markers: the markers that are seen at all.
        pixels: (K, 2) raw pixels.
        directions: (K, C) what multiplies the chain's coefficients.

    """

    row: NDArray[np.int64]
    marker: NDArray[np.int64]
    markers: tuple[str, ...]
    pixels: Array
    directions: ComplexArray


def rows_to_fit(recording: Recording, trajectories: Sequence[str] | None = None) -> NDArray[np.int64]:
    """Return the rows of the named trajectories, or of all that are not held out; raises `InputError` for none."""
    present = sorted({str(name) for name in recording.trajectory})
    if trajectories is None:
        rows = np.flatnonzero(~np.isin(recording.trajectory, recording.held_out))
        if not len(rows):
            raise InputError(
                f"recording.json: held_out names every trajectory ({', '.join(present)}); leave one to calibrate on"
            )
        return rows
    for name in trajectories:
        if name not in present:
            raise InputError(f"samples.csv: no trajectory '{name}'{nearest(name, present)}")
    return np.flatnonzero(np.isin(recording.trajectory, trajectories))


def observe(recording: Recording, rows: NDArray[np.int64]) -> Observations:
    """Gather the seen markers of `rows`; raises `InputError` for no marker at all or too few poses."""
    chain = Chain(recording.arm)
    q_cmd = recording.q_cmd[rows]
    seen = {name: np.flatnonzero(np.isfinite(px[rows]).all(axis=-1)) for name, px in recording.markers_px.items()}
    seen = {name: at for name, at in seen.items() if len(at)}
    if not seen:
        raise InputError(
            f"samples.csv: no marker is seen in any of the {len(rows)} poses to calibrate on; "
            "every marker cell is empty, check the light, the focus and the marker measurement"
        )
    refuse_too_few(recording.arm, len(np.unique(np.concatenate(list(seen.values())))), fewest_poses(recording.arm))
    return Observations(
        row=np.concatenate([rows[at] for at in seen.values()]),
        marker=np.concatenate([np.full(len(at), number) for number, at in enumerate(seen.values())]),
        markers=tuple(seen),
        pixels=np.concatenate([recording.markers_px[name][rows[at]] for name, at in seen.items()]),
        directions=np.concatenate([chain.directions(q_cmd[at], name) for name, at in seen.items()]),
    )


def fewest_poses(arm: Arm) -> int:
    """Poses below which no calibration is made: one more than the tip alone needs for n links and the base.

    Each pose of the tip gives two numbers; n complex links and the base are 2 n + 2. More markers in one picture do not
    help: what is wrong with a pose is wrong with all of them.
    """
    return arm.n_joints + 2


def refuse_too_few(arm: Arm, found: int, wanted: int) -> None:
    """Raise `InputError` that says how many poses are missing."""
    if found < wanted:
        poses = f"{found} pose" + ("s" if found != 1 else "")
        joints = f"{arm.n_joints} joint" + ("s" if arm.n_joints > 1 else "")
        raise InputError(
            f"samples.csv: {poses} with a measurement to calibrate on, an arm of {joints} needs at "
            f"least {wanted}: measure {wanted - found} more"
        )
