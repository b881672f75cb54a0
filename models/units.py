"""The one place where units are converted: millimetres outside MuJoCo, metres inside; degrees only for people."""

from __future__ import annotations

MM_PER_M = 1000.0
M_PER_MM = 1.0 / MM_PER_M
