"""The true geometry in the terms of the report's, and whether its intervals hold it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from armtwin.models.arm import Arm
from armtwin.models.statistics import Z95


def true_geometry(arm: Arm, truth: Mapping[str, Any]) -> dict[str, float]:
    """Return base, lengths and zeros by the names of a diagnosis; the last zero carries the turn of (l4, l5)."""
    lengths, zeros = np.array(truth["link_lengths_mm"]), np.array(truth["joint_offsets_rad"])
    base = {"base_x_mm": truth["base_in_board_mm"][0], "base_y_mm": truth["base_in_board_mm"][1]}
    if arm.has_tip_offset:
        drawn = arm.link_lengths_mm
        zeros[-1] -= np.arctan2(lengths[-1], lengths[-2]) - np.arctan2(drawn[-1], drawn[-2])
        lengths = np.array([*lengths[:-2], np.hypot(lengths[-2], lengths[-1])])
    sizes = {f"{name}_mm": length for name, length in zip(arm.link_names, lengths, strict=True)}
    return base | sizes | {f"theta{k + 1}_zero_rad": zero for k, zero in enumerate(zeros)}


def geometry_covered(arm: Arm, truth: Mapping[str, Any], geometry: Mapping[str, Any]) -> dict[str, bool]:
    """By parameter, whether value ± 1.96 std holds the truth."""
    true = true_geometry(arm, truth)
    return {
        name: abs(interval["value"] - true[name]) <= Z95 * interval["std"]
        for name, interval in geometry.items()
        if name in true
    }
