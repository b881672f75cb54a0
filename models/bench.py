"""What a bench is: the pipeline cannot tell the simulated, the emulated and the real one apart."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Frame:
    """One picture: `image` (H, W, 3) uint8 in OpenCV's BGR order, and two times, s since the bench was connected.

    `time_s` is when it was taken, `commanded_s` when the last command before it was given; None before the first.
    """

    image: NDArray[np.uint8]
    time_s: float
    commanded_s: float | None = None


@runtime_checkable
class Bench(Protocol):
    """An arm and a camera that can be commanded and watched."""

    def connect(self) -> None:
        """Open the arm and the camera; raises `ArmtwinError` where one cannot be had."""

    def move(self, q_cmd_rad: NDArray[np.float64]) -> None:
        """Command (n,) joint angles, rad, and return when the arm has come to rest as far as the bench can tell."""

    def capture(self) -> Frame:
        """Take one picture of the arm as it stands now."""

    def close(self) -> None:
        """Detach the servos and release the camera; safe to call twice."""
