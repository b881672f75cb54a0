"""A plan's power in words and numbers for people."""

from __future__ import annotations

import numpy as np

from armtwin.scenarios.power.place import PlacePower
from armtwin.scenarios.power.setting import Setting

# Answers that are told of a fault that is too small.
_TOLD = 2
_LEAST_TOLD = 0.1


def about(setting: Setting) -> str:
    """Say what was planned."""
    markers = ", ".join(name.upper() for name in setting.markers)
    return f"{len(setting.plan)} poses, markers {markers}, noise {setting.noise_px:g} px"


def amount(size: float | None, unit: str) -> str:
    """Write a size with its unit; angles in degrees."""
    if size is None:
        return "no size"
    return f"{np.degrees(size):.2g}°" if unit == "rad" else f"{size:.2g} {unit}".strip()


def needed(one: PlacePower, share: int) -> str:
    """Say from which size on a fault is found in 50 or 90 of 100 recordings."""
    if one.fixed:
        return f"found in {100 * one.share:.0f}"
    return amount(one.size_50 if share == 50 else one.size_90, one.unit)


def taken_for(one: PlacePower) -> str:
    """Say what a fault half as large as is found nine times of ten is taken for."""
    told = [(name, share) for name, share in one.taken_for.items() if share >= _LEAST_TOLD][:_TOLD]
    return ", ".join(f"{name.replace('|', ' or ')} {100 * share:.0f} %" for name, share in told)
