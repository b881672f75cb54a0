"""A marker that left its command for good is told from red clutter by keeping its angle from picture to picture."""

from __future__ import annotations

import numpy as np
import pytest

from armtwin.calib.markers import Disc, identify
from armtwin.calib.markers.slipped import slipped_commands
from armtwin.models.arm import Arm, nominal_arm
from armtwin.models.camera import Camera
from tests.calib.markers.test_identify import PLANE_MM, disc_at, markers

COMMANDS = np.array([[0.03 * k, 0.2 - 0.02 * k, -0.3 + 0.04 * k] for k in range(12)])


def pictures(arm: Arm, camera: Camera, q: np.ndarray) -> list[tuple[Disc, ...]]:
    return [tuple(disc_at(camera, place) for place in markers(arm, one)) for one in q]


@pytest.mark.parametrize("slip", [0.6, 1.2, -1.5])
def test_a_horn_that_slipped_far_loses_no_marker(webcam: Camera, slip: float) -> None:
    arm = nominal_arm()
    found = pictures(arm, webcam, COMMANDS + np.array([0.0, 0.0, slip]))
    readings = [identify(discs, arm, webcam, PLANE_MM, q) for discs, q in zip(found, COMMANDS, strict=True)]
    turned = slipped_commands(found, readings, arm, webcam, PLANE_MM, COMMANDS)
    for row, (discs, reading) in enumerate(zip(found, readings, strict=True)):
        again = identify(discs, arm, webcam, PLANE_MM, turned[row]) if row in turned else reading
        assert again.discs["f"] is discs[3]


def test_clutter_that_keeps_no_angle_is_no_marker(webcam: Camera) -> None:
    arm, rng = nominal_arm(), np.random.default_rng(1)
    anywhere = COMMANDS + np.column_stack([np.zeros((12, 2)), rng.uniform(0.8, 2 * np.pi - 0.8, 12)])
    found = pictures(arm, webcam, anywhere)
    readings = [identify(discs, arm, webcam, PLANE_MM, q) for discs, q in zip(found, COMMANDS, strict=True)]
    assert slipped_commands(found, readings, arm, webcam, PLANE_MM, COMMANDS) == {}
