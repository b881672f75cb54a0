"""What a moving arm's log says of friction and of what is in the arm's way, in sentences."""

from __future__ import annotations

import numpy as np

from armtwin.calib.motion.diagnosis import MotionDiagnosis
from armtwin.calib.motion.ladder import Climbed
from armtwin.models.motion.loop import INDEX

# A share of the load below this is none.
_GROWS = 0.01
# Rungs that predict alike to this share cannot be told apart by these motions.
_ALIKE = 0.04


def rubbing(found: MotionDiagnosis) -> list[str]:
    """Say how each joint rubs, whether friction grows with the load, and what these motions cannot tell apart."""
    out = []
    for joint, one in found.arm.climbed.items():
        if joint in found.loud or "friction" not in found.arm.joints[joint].effects:
            continue
        p = found.arm.joints[joint].fit.p
        moving, still = (float(np.degrees(p[INDEX[name]])) for name in ("coulomb_rad", "stribeck_rad"))
        name = found.recording.joint_names[joint]
        text = f"{name} rubs: its servo stands still within {moving + still:.2g}° of its command"
        if still > 0.1 * moving:
            speed = float(np.degrees(p[INDEX["stribeck_speed_rad_s"]]))
            text += f", and within {moving:.2g}° beyond {speed:.2g}°/s"
        out.append(f"{text}{_grows(one, p)}.{_alike(one)}")
    shaped = [found.recording.joint_names[joint] for joint, one in found.arm.climbed.items() if len(one.load_of_basis)]
    if shaped:
        out.append(
            f"How the load of {', '.join(shaped)} turns with the pose was fitted, for masses and zeros of a model are "
            "seldom true: the twin in MuJoCo bears the model's own load."
        )
    return out


def _grows(one: Climbed, p: np.ndarray) -> str:
    bears = p[INDEX["droop_rad_nm"]] > 0.0
    load = max(p[INDEX["load_share"]], p[INDEX["stribeck_load_share"]]) if bears else 0.0
    motor = max(p[INDEX["drive_share"]], p[INDEX["stribeck_drive_share"]])
    return (
        "; it grows with the load" if load > _GROWS else "; it grows with the motor's torque" if motor > _GROWS else ""
    )


def _alike(one: Climbed) -> str:
    least = min(one.scores.values())
    alike = [name for name, score in one.scores.items() if score < least + _ALIKE and name not in ("none", "play")]
    if len(alike) < 2:
        return ""
    return f" These motions cannot tell its forms {' and '.join(alike)} apart: they predict other motions alike."


def in_the_way(found: MotionDiagnosis) -> list[str]:
    """Say where something stopped the arm, and how many samples were left out of the fit for it."""
    recording, out = found.recording, []
    for joint, one in found.arm.climbed.items():
        for motion in recording.motions:
            rows = np.intersect1d(one.obstructed, recording.rows_of(motion))
            if len(rows):
                begin, end = recording.time_s[rows[[0, -1]]]
                out.append(
                    f"Something stops {recording.joint_names[joint]} in {motion}, between {begin:.1f} and {end:.1f} s: "
                    f"{len(rows)} samples of it were left out of the fit."
                )
    return out
