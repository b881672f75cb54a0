"""What a bench is: the pipeline cannot tell the simulated, the emulated, the real and the remote one apart."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol, Self, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from armtwin.models.arm import Arm
from armtwin.models.camera import Camera
from armtwin.models.joint_limits import JointLimits


@dataclass(frozen=True, eq=False)
class Frame:
    """One picture: `image` (H, W, 3) uint8 in OpenCV's BGR order, and two times, s since the bench was connected.

    `time_s` is when it was taken, `commanded_s` when the last command before it was given; None before the first.
    """

    image: NDArray[np.uint8]
    time_s: float
    commanded_s: float | None = None


@dataclass(frozen=True, eq=False)
class BenchDescription:
    """What a bench says of itself before it is opened.

    Attributes:
        kind: hardware, emulated, simulated or remote.
        arm, camera, arm_plane_z_mm: as assumed, as a recording declares them.
        limits: of its joints and of a step.
        hangs_loads: whether `hang` can hang a mass at the tip.
        actuation: what a command becomes on this bench, as plain data that nobody but the bench understands. Two
            recordings belong together only where it is the same.

    """

    kind: str
    arm: Arm
    camera: Camera
    arm_plane_z_mm: float
    limits: JointLimits
    hangs_loads: bool = False
    actuation: Mapping[str, Any] = field(default_factory=dict)


@runtime_checkable
class Bench(Protocol):
    """An arm and a camera that can be commanded and watched; as a context manager it is connected and closed."""

    @property
    def description(self) -> BenchDescription:
        """What it is; known before it is connected."""

    @property
    def notes(self) -> tuple[str, ...]:
        """What a person should know of the camera as it was opened, one line each; empty before."""

    @property
    def detached(self) -> bool:
        """Whether the servos are known to be without pulses."""

    @property
    def clock_origin_s(self) -> float | None:
        """Unix time of the moment that its times count from; None where its clock is no clock of this world."""

    def connect(self) -> None:
        """Open the arm and the camera; raises `ArmtwinError` where one cannot be had."""

    def hang(self, payload_kg: float) -> None:
        """Hang a known mass at the tip before the next move; raises `InputError` where nobody can."""

    def move(self, q_cmd_rad: NDArray[np.float64]) -> None:
        """Command (n,) joint angles, rad, and return when the arm has come to rest as far as the bench can tell."""

    def capture(self) -> Frame:
        """Take one picture of the arm as it stands now."""

    def close(self) -> None:
        """Detach the servos and release the camera; safe to call twice."""

    def __enter__(self) -> Self: ...

    def __exit__(self, *error: object) -> None: ...


@runtime_checkable
class FilmingBench(Bench, Protocol):
    """A bench that films its arm on the way."""

    def film(self, time_s: NDArray[np.float64], q_cmd: NDArray[np.float64]) -> Iterator[Frame]:
        """Stream (N, n) commands, rad, at (N,) times, s, from now, and yield a picture for each.

        A frame's `commanded_s` is when its command was given, not later than its `time_s`.
        """
