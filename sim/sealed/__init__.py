"""Sealed worlds: recordings with a hidden effect and the truth about them, made by the physical simulation."""

from sim.sealed.draw import STRENGTHS, Sealed, Strength, bench_of, draw_world, hide
from sim.sealed.ranges import EFFECTS

__all__ = ["EFFECTS", "STRENGTHS", "Sealed", "Strength", "bench_of", "draw_world", "hide"]
