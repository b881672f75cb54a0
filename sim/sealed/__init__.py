"""Sealed worlds: recordings with a hidden effect and the truth about them, made by the physical simulation."""

from armtwin.sim.sealed.displacement import Scene, moved_px
from armtwin.sim.sealed.draw import (
    STRENGTHS,
    Sealed,
    Strength,
    bench_of,
    draw_world,
    hide,
    record,
    scale,
    sealed_effects,
    truth_of,
)
from armtwin.sim.sealed.of_size import Wanted, draw_of_size

__all__ = [
    "STRENGTHS",
    "Scene",
    "Sealed",
    "Strength",
    "Wanted",
    "bench_of",
    "draw_of_size",
    "draw_world",
    "hide",
    "moved_px",
    "record",
    "scale",
    "sealed_effects",
    "truth_of",
]
