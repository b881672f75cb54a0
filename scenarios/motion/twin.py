"""The extended twin of a moving arm as a file."""

from __future__ import annotations

from typing import Any

import tomli_w

from armtwin.calib.motion.diagnosis import MotionCause, MotionDiagnosis
from armtwin.models.arm import Arm
from armtwin.models.motion.loop import INDEX
from armtwin.models.recordings.writer import arm_table
from armtwin.scenarios.motion.words import headline

SCHEMA = "armtwin.twin/1"


def motion_twin_text(found: MotionDiagnosis) -> str:
    """Return `twin.toml`: the arm, its zeros, and each cause with its parameters."""
    recording = found.recording
    arm = recording.arm
    table: dict[str, Any] = {
        "schema": SCHEMA,
        "motion": "moving",
        "arm": arm_table(arm)
        if isinstance(arm, Arm)
        else {"name": arm.name, "model": arm.model.name, "joints": list(arm.joints)},
        "geometry": {
            "joint_errors_rad": [float(model.fit.p[INDEX["zero_rad"]]) for model in found.arm.joints],
        },
    }
    if isinstance(arm, Arm):
        table["geometry"] = {"length_errors_mm": [0.0] * len(arm.link_lengths_mm), **table["geometry"]}
    effects = [_effect(cause) for cause in found.causes if cause.parameters]
    if effects:
        table["effects"] = effects
    return f"# {headline(found)}\n" + tomli_w.dumps(table)


def _effect(cause: MotionCause) -> dict[str, Any]:
    site = {} if cause.joint is None else {"joint": cause.joint}
    return {"effect": cause.effect, **site, "parameters": {k: v.value for k, v in cause.parameters.items()}}
