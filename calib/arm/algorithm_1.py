"""The paper's Algorithm 1, faithful to equations (19) to (23): gradient descent on the error of F.

What the paper leaves open, and what is done here:

- F is measured relative to A in the same picture (equation 11), in mm, so the base drops out.
- Units of X are mm and degrees, as in Table 4; equation (22) is taken by degree.
- alpha is not given. It is 1 / s^2, with s the largest singular value of the derivative of all (F'_x, F'_y) by X at X0:
  equation (22) is that derivative projected on unit vectors, so this is the longest step that cannot overshoot there.
- errorMax is not given. It is 0.25 mm, the accuracy that the paper states for its vision system; the loop ends below
  it, or after a bounded number of steps, which the paper's own bench (1.8 mm left) must have reached some other way.
- Table 4's separate delta_l4, delta_l5 and delta_theta3 come from X0: nothing in the data moves X along the gauge.
- (19) is not differentiable where an error is zero; the gradient of such a point is taken as zero.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.arm.calibration import ArmCalibration
from armtwin.calib.arm.chain import Chain, ComplexArray
from armtwin.calib.arm.identifiability import GAUGE
from armtwin.calib.arm.observations import fewest_poses, refuse_too_few, rows_to_fit
from armtwin.models.camera import back_project
from armtwin.models.errors import InputError
from armtwin.models.kinematics import Deviation, is_closed_form
from armtwin.models.recordings.recording import Recording

Array = NDArray[np.float64]

# X0 of Algorithm 1: delta l1, l2, l4, l5 in mm, delta theta1, theta2, theta3 in degrees.
X0 = (5.0, 5.0, 1.0, 1.0, 5.0, 5.0, 5.0)
ERROR_MAX_MM = 0.25
MAX_STEPS = 2000


@dataclass(frozen=True, eq=False)
class Descent:
    """How Algorithm 1 went: X in mm and degrees, the mean error (21) before each step, mm, and why it stopped."""

    x: Array
    errors_mm: Array
    alpha: float
    stopped: str


def calibrate(
    recording: Recording,
    trajectories: Sequence[str] | None = None,
    start: Sequence[float] = X0,
    error_max_mm: float = ERROR_MAX_MM,
    max_steps: int = MAX_STEPS,
) -> ArmCalibration:
    """Run Algorithm 1 on the named trajectories of a recording of the paper's arm; by default all not held out.

    `start` is X0 in mm and degrees. Raises `InputError` for another arm, or fewer poses with A and F than five.
    """
    if not is_closed_form(recording.arm):
        raise InputError(
            f"recording.json: Algorithm 1 is for arm planar3, found '{recording.arm.name}'; use least-squares"
        )
    rows = rows_to_fit(recording, trajectories)
    measured, seen_rows, base = measured_tip(recording, rows)
    refuse_too_few(recording.arm, len(seen_rows), fewest_poses(recording.arm))
    descent = descend(Chain(recording.arm), recording.q_cmd[seen_rows], measured, start, error_max_mm, max_steps)
    chain = Chain(recording.arm)
    deviation = deviation_of(descent.x)
    left = _errors(chain, chain.directions(recording.q_cmd[seen_rows], "f"), measured, descent.x)[0]
    return ArmCalibration(
        method="algorithm-1",
        deviation=deviation,
        base_in_board_mm=base,
        names=chain.names,
        values=np.concatenate([deviation.lengths_mm, deviation.joints_rad]),
        covariance=np.full((7, 7), np.nan),
        degrees_of_freedom=0,
        clustered_std=np.full(7, np.nan),
        identifiable=6,
        singular_values=np.full(7, np.nan),
        gauge=(GAUGE.split(";")[0] + "; here the starting vector decides it",),
        ties=(f"steps of alpha {descent.alpha:.3g}: {len(descent.errors_mm) - 1}, stopped by {descent.stopped}",),
        noise=float(np.sqrt((left**2).mean() / 2.0)),
        rms_px=float("nan"),
        rms_mm=float(np.sqrt((left**2).mean())),
        n_poses=len(seen_rows),
        n_used=len(seen_rows),
        outliers=(),
    )


def measured_tip(recording: Recording, rows: NDArray[np.int64]) -> tuple[Array, NDArray[np.int64], Array]:
    """Tip F relative to A, (N, 2) robot mm (equations 11, 12, 16), rows that show both, and the mean of A, (3,) mm."""
    first, last = recording.arm.marker_names[0], recording.arm.marker_names[-1]
    if recording.camera is None or recording.arm_plane_z_mm is None or not {first, last} <= set(recording.markers_px):
        raise InputError(
            f"samples.csv: the tip's place needs the markers {first} and {last} in pixels; use least-squares"
        )
    a, f = (
        back_project(recording.camera, recording.markers_px[name][rows], recording.arm_plane_z_mm)
        for name in (first, last)
    )
    seen = np.isfinite(a).all(axis=-1) & np.isfinite(f).all(axis=-1)
    between = (f - a)[seen]
    base = a[seen].mean(axis=0) if seen.any() else np.full(3, np.nan)
    return np.stack([-between[:, 0], between[:, 1]], axis=-1), rows[seen], base


def descend(
    chain: Chain,
    q_cmd: Array,
    measured: Array,
    start: Sequence[float] = X0,
    error_max_mm: float = ERROR_MAX_MM,
    max_steps: int = MAX_STEPS,
) -> Descent:
    """Algorithm 1, lines 5 to 16: (N, 3) commands, rad, and (N, 2) measured F, robot mm, to X."""
    x = np.asarray(start, dtype=float)
    directions = chain.directions(q_cmd, "f")
    moved = _moved(chain, directions, x)[1]
    alpha = 1.0 / np.linalg.norm(np.concatenate([moved.real, moved.imag]), 2) ** 2
    history: list[float] = []
    stopped = f"the bound of {max_steps} steps"
    while True:
        E, J = _errors(chain, directions, measured, x)
        history.append(float(E.mean()))
        if history[-1] < error_max_mm:
            stopped = f"error below errorMax = {error_max_mm:g} mm"
            break
        if len(history) > max_steps:
            break
        x = x - alpha * (E @ J)
    return Descent(x, np.array(history), float(alpha), stopped)


def deviation_of(x: Array) -> Deviation:
    """X in mm and degrees as a deviation."""
    return Deviation(x[:4].copy(), np.radians(x[4:]))


def _moved(chain: Chain, directions: ComplexArray, x: Array) -> tuple[ComplexArray, ComplexArray]:
    """F' by (17, 18) as complex numbers, (N,), and its (N, 7) derivative by X, mm per mm and per degree."""
    c, slope = chain.coefficients(np.concatenate([x[:4], np.radians(x[4:])]))
    slope[:, 4:] *= np.pi / 180.0
    return directions @ c, directions @ slope


def _errors(chain: Chain, directions: ComplexArray, measured: Array, x: Array) -> tuple[Array, Array]:
    """E by (19, 20), (N,) mm, and J by (22), (N, 7)."""
    tip, moved = _moved(chain, directions, x)
    off = tip - (measured[:, 0] + 1j * measured[:, 1])
    E = np.abs(off)
    unit = np.divide(off, E, out=np.zeros_like(off), where=E > 0)
    return E, np.real(unit.conj()[:, None] * moved)
