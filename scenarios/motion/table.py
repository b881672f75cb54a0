"""The diagnosis of a moving recording as data: the content of `diagnosis.json` (`armtwin.diagnosis/1`)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.motion.diagnosis import MotionCause, MotionDiagnosis
from armtwin.calib.motion.experiment import NextMotion
from armtwin.calib.motion.set_up import SetUpFault
from armtwin.models.arm import Arm
from armtwin.models.kinematics import marker_positions
from armtwin.models.motion.loop import INDEX
from armtwin.scenarios.diagnosis.table import SCHEMA
from armtwin.scenarios.motion.remainder import follows
from armtwin.scenarios.motion.words import next_table

Array = NDArray[np.float64]


def motion_table(found: MotionDiagnosis, proposed: NextMotion | None = None) -> dict[str, Any]:
    """Return the content of `diagnosis.json`."""
    against = follows(found)
    return {
        "schema": SCHEMA,
        "verdict": found.verdict,
        **({"set_up": [_set_up(fault) for fault in found.set_up]} if found.set_up else {}),
        "causes": [_cause(cause) for cause in found.causes],
        "geometry": _geometry(found),
        "held_out": _held_out(found),
        "unexplained": {
            "rms_rad": _left(found),
            "structured": bool(against),
            "against": against,
        },
        "next_experiment": next_table(proposed),
    }


def _cause(cause: MotionCause) -> dict[str, Any]:
    return {
        "effect": cause.effect,
        "joint": cause.joint,
        "marker": None,
        "parameters": {name: {"value": one.value, "std": one.std} for name, one in cause.parameters.items()},
        "equivalents": [{"effect": effect, "joint": cause.joint, "marker": None} for effect in cause.equivalents],
        "p_value": cause.p_value,
        "explained_percent": cause.explained_percent,
    }


def _set_up(fault: SetUpFault) -> dict[str, Any]:
    return {"error": fault.error, "joints": list(fault.joints), "said": fault.said, "remedy": fault.remedy}


def _geometry(found: MotionDiagnosis) -> dict[str, Any]:
    zeros = {
        f"delta_theta{model.joint + 1}_rad": {"value": float(model.fit.p[INDEX["zero_rad"]]), "std": None}
        for model in found.arm.joints
    }
    return {"identifiable": len(zeros), "parameters": zeros, "gauge": []}


def _held_out(found: MotionDiagnosis) -> dict[str, Any]:
    joints = [
        {
            "trajectory": one.trajectory,
            "joint": one.joint + 1,
            "command_rms_rad": one.command_rms_rad,
            "nominal_rms_rad": one.nominal_rms_rad,
            "before_rms_rad": one.before_rms_rad,
            "after_rms_rad": one.after_rms_rad,
            "after_worst_rad": one.after_worst_rad,
            "noise_floor_rad": one.noise_floor_rad,
        }
        for one in found.held_out
    ]
    return {
        "trajectories": list(dict.fromkeys(one.trajectory for one in found.held_out)),
        **_at_the_tip(found),
        "gain_percent": found.gain.percent,
        "gain_ci95_percent": [found.gain.low, found.gain.high],
        "joints": joints,
    }


def _at_the_tip(found: MotionDiagnosis) -> dict[str, float]:
    """Return the held-out error of the tip, mm, by each model, where the links' lengths are known."""
    arm = found.recording.arm
    rows = found.problem.held & np.isfinite(found.recording.q_meas).all(axis=1)
    if not isinstance(arm, Arm) or not rows.any():
        return {}
    measured = found.recording.q_meas[rows]
    noise = np.array([model.noise_rad for model in found.arm.joints])
    rng = np.random.default_rng(0)
    out = {}
    for name, angles in (
        ("nominal", found.predicted("nominal")[rows]),
        ("before", found.predicted("before")[rows]),
        ("after", found.predicted("after")[rows]),
        ("noise_floor", measured + noise * rng.standard_normal(measured.shape)),
    ):
        gap = marker_positions(arm, angles)[:, -1] - marker_positions(arm, measured)[:, -1]
        key = "noise_floor_mm" if name == "noise_floor" else f"{name}_rms_mm"
        out[key] = float(np.sqrt(np.mean((gap**2).sum(axis=-1))))
    return out


def _left(found: MotionDiagnosis) -> float:
    """Return what all joints' models leave on the fitted rows, rad."""
    squares = [float(np.mean(model.fit.e[found.problem.series[model.joint].used] ** 2)) for model in found.arm.joints]
    return float(np.sqrt(np.mean(squares)))
