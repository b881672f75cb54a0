"""Tables that people published of their servos: what was once answered badly is answered as the table says."""

from __future__ import annotations

import numpy as np

from armtwin.calib.diagnosis.diagnosis import diagnose
from armtwin.models.arm import Arm
from armtwin.models.recordings.recording import Recording, make_samples

# An encoder's angle (second row, degrees) every 100 us of pulse (first row, degrees nominal), one way.
ENCODER_DEG = np.array(
    [
        [71.1, 62.1, 53.1, 44.1, 35.1, 26.1, 17.1, 8.1, -0.9, -9.9],
        [78.6, 66.0, 57.0, 44.7, 36.45, 26.55, 17.25, 8.55, -0.3, -9.6],
    ]
)
# Angles of a hobby servo's arm (second row) and the pulses that reach them (first row, degrees), there and back.
ELBOW_DEG = np.array(
    [
        [29.9, 56.9, 68.9, 81.1, 94.1, 107.5, 137.5, 136.3, 106.3, 92.9, 80.3, 67.3, 55.3, 27.3],
        [30.0, 60.0, 75.0, 90.0, 105.0, 120.0, 150.0, 150.0, 120.0, 105.0, 90.0, 75.0, 60.0, 30.0],
    ]
)


def table(degrees: np.ndarray, length_mm: float) -> Recording:
    commands, readings = np.round(np.radians(degrees), 8)
    turned = np.r_[0.0, np.diff(commands)]
    return Recording(
        arm=Arm("servo", np.array([length_mm]), np.zeros(2)),
        sample=make_samples(len(commands)),
        time_s=np.full(len(commands), np.nan),
        trajectory=np.where(turned < 0.0, "back", "there"),
        q_cmd=commands[:, None],
        q_meas=readings[:, None],
    )


def test_of_ten_angles_in_one_direction_gain_and_curve_are_told_as_one_cause() -> None:
    found = diagnose(table(ENCODER_DEG, 100.0))
    assert found.verdict == "named"
    assert [cause.active.effect.name for cause in found.causes] == ["servo_nonlinearity"]


def test_of_fourteen_angles_there_and_back_play_is_told_beside_the_curve() -> None:
    found = diagnose(table(ELBOW_DEG, 80.0))
    first, second = ({one.effect.name for one in (c.active, *c.equivalents)} for c in found.causes)
    assert "servo_nonlinearity" in first
    assert "backlash" in second
