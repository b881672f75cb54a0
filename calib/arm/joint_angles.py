"""Calibration on measured joint angles alone (an encoder, a protractor): the joints' zeros, no lengths."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.arm.calibration import ArmCalibration, Outlier
from armtwin.calib.arm.chain import Chain
from armtwin.calib.arm.observations import refuse_too_few
from armtwin.models.errors import InputError
from armtwin.models.kinematics import Deviation
from armtwin.models.recordings.recording import Recording
from armtwin.models.statistics import MAD_TO_STD

Array = NDArray[np.float64]

# The mean of two angles is the least that also tells its own noise.
_FEWEST = 2
# Angles beyond this many robust standard deviations of their joint are left out.
_OUTLIER = 5.0
# Noise below this is rounding of the file, rad.
_FLOOR_RAD = 1e-9


def calibrate(recording: Recording, rows: NDArray[np.int64]) -> ArmCalibration:
    """Estimate each joint's zero, rad, as the mean of measured less commanded angle over `rows`.

    Raises `InputError` where a joint has fewer than two measured angles.
    """
    if recording.q_meas is None:
        raise InputError("samples.csv: no marker and no measured angle (theta1_meas_rad, ...): nothing to calibrate on")
    chain = Chain(recording.arm)
    difference = recording.q_meas[rows] - recording.q_cmd[rows]
    n = recording.arm.n_joints
    zeros, variances, freedom, squares = np.zeros(n), np.zeros(n), np.zeros(n, dtype=int), 0.0
    outliers: list[Outlier] = []
    for joint in range(n):
        measured = np.flatnonzero(np.isfinite(difference[:, joint]))
        refuse_too_few(recording.arm, len(measured), _FEWEST)
        off = difference[measured, joint] - np.median(difference[measured, joint])
        used = np.abs(off) <= _OUTLIER * max(MAD_TO_STD * float(np.median(np.abs(off))), _FLOOR_RAD)
        kept = difference[measured[used], joint]
        zeros[joint], freedom[joint] = kept.mean(), len(kept) - 1
        variances[joint] = kept.var(ddof=1) / len(kept) if len(kept) > 1 else np.nan
        squares += float(((kept - kept.mean()) ** 2).sum())
        outliers += [
            Outlier(int(recording.sample[rows[k]]), f"theta{joint + 1}", float(difference[k, joint] - zeros[joint]))
            for k in measured[~used]
        ]
    return ArmCalibration(
        method="joint-angles",
        deviation=Deviation(np.zeros(len(chain.length_names)), zeros),
        base_in_board_mm=None,
        names=chain.joint_names,
        values=zeros,
        covariance=np.diag(variances),
        degrees_of_freedom=int(freedom.min()),
        clustered_std=np.sqrt(variances),
        identifiable=n,
        singular_values=np.ones(n),
        gauge=(),
        ties=(f"joint angles say nothing about {', '.join(chain.length_names)}; they stay as drawn",),
        noise=float(np.sqrt(squares / max(int(freedom.sum()), 1))),
        rms_px=float("nan"),
        rms_mm=float("nan"),
        n_poses=len(rows),
        n_used=int((freedom + 1).sum()),
        outliers=tuple(outliers),
    )
