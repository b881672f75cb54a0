"""The true geometry in the terms of the report's, and whether its intervals hold it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from armtwin.models.arm import Arm
from armtwin.scenarios.scoring.judge import INTERVAL


def true_geometry(arm: Arm, truth: Mapping[str, Any]) -> dict[str, float]:
    """Return base, lengths and zeros by the names of a diagnosis; planar3's zero 3 carries the turn of (l4, l5)."""
    lengths, zeros = np.array(truth["link_lengths_mm"]), np.array(truth["joint_offsets_rad"])
    base = {"base_x_mm": truth["base_in_board_mm"][0], "base_y_mm": truth["base_in_board_mm"][1]}
    if arm.is_planar3:
        drawn = arm.link_lengths_mm
        turn = np.arctan2(lengths[3], lengths[2]) - np.arctan2(drawn[3], drawn[2])
        zeros = zeros - np.array([0.0, 0.0, turn])
        sizes = {"l1_mm": lengths[0], "l2_mm": lengths[1], "l45_mm": np.hypot(lengths[2], lengths[3])}
    else:
        sizes = {f"l{k + 1}_mm": length for k, length in enumerate(lengths)}
    return base | sizes | {f"theta{k + 1}_zero_rad": zero for k, zero in enumerate(zeros)}


def geometry_covered(arm: Arm, truth: Mapping[str, Any], geometry: Mapping[str, Any]) -> dict[str, bool]:
    """By parameter, whether value ± 1.96 std holds the truth."""
    true = true_geometry(arm, truth)
    return {
        name: abs(interval["value"] - true[name]) <= INTERVAL * interval["std"]
        for name, interval in geometry.items()
        if name in true
    }
