"""A plan's power in words and numbers for people."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from armtwin.models.catalogue.site import Site
from armtwin.models.statistics import Z95
from armtwin.scenarios.power.place import PlacePower
from armtwin.scenarios.power.setting import Setting
from armtwin.sim.sealed.of_size import place_name

Array = NDArray[np.float64]

# Answers that are told of a fault that is too small.
_TOLD = 2
_LEAST_TOLD = 0.1


def label(effect: str, site: Site) -> str:
    """An effect and its place for people."""
    place = place_name(site)
    return effect if place == "whole" else f"{effect}, {place}"


def shown_size(size: Array, unit: str) -> Array:
    """Return sizes as people read them: angles in degrees."""
    return np.degrees(size) if unit == "rad" else np.asarray(size)


def unit_words(unit: str) -> str:
    """Return the unit that goes with `shown_size`."""
    return "degrees" if unit == "rad" else unit


def axis(unit: str) -> str:
    """Return the title of an axis of sizes."""
    return f"size, {unit_words(unit)}" if unit else "size, as a share"


def known_to(one: PlacePower) -> str:
    """Say to how many percent, as an interval of 95 %, the best known parameter of a fault is then known."""
    known = max((abs(value) / std for value, std in one.estimates.values() if std > 0 and value), default=0.0)
    return f"± {100.0 * Z95 / known:.0f} %" if known > 0 else "–"


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
