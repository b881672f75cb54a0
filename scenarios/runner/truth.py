"""What is true of a simulated bench: `truth.json`."""

from __future__ import annotations

from typing import Any

from armtwin.models.kinematics import Deviation
from armtwin.models.recordings.writer import camera_table
from armtwin.scenarios.runner.world import declared_arm, true_camera, true_deviation
from armtwin.scenarios.scenario import ScenarioFile

SCHEMA = "armtwin.truth/1"


def truth_table(scenario: ScenarioFile) -> dict[str, Any]:
    """Return the content of `truth.json`."""
    delta: Deviation = true_deviation(scenario)
    return {
        "schema": SCHEMA,
        "link_lengths_mm": declared_arm(scenario).link_lengths_mm + delta.lengths_mm,
        "joint_offsets_rad": delta.joints_rad,
        "camera": camera_table(true_camera(scenario)),
        "arm_plane_z_mm": scenario.bench.arm_plane_z_mm,
        "base_in_board_mm": [*scenario.bench.base_in_board_mm, scenario.bench.arm_plane_z_mm],
        "effects": [
            {"effect": e.name, "joint": e.joint, "marker": e.marker, "parameters": e.parameters}
            for e in scenario.effects
        ],
    }
