"""One picture of the served bench, and what twin and detector say of it."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from armtwin.models.arm import Arm
from armtwin.models.bench import Frame
from armtwin.models.camera import Camera, back_project
from armtwin.models.errors import JobError

Array = NDArray[np.float64]

_JPEG_QUALITY = 82


@dataclass(frozen=True)
class Miss:
    """How far a recorded pose was off: the twin's tip and the measured less the expected tip, mm, the worst marker, mm.

    `twin` is the name of the one that stood beside the bench then; `tip_mm` and `miss_mm` are None without a tip found.
    """

    twin: str
    q_cmd_rad: list[float]
    tip_mm: list[float] | None
    miss_mm: list[float] | None
    worst_mm: float | None


@dataclass(frozen=True, eq=False)
class Shot:
    """A picture as it was taken.

    Attributes:
        number: counts the pictures of a visit from 1.
        frame: the picture and when it was taken.
        q_cmd: (n,) the command it was taken at, rad.
        measured_px: (2,) raw pixels of each marker that was found.
        twin_px: (2,) where the twin expects each marker.
        twin_bodies, true_bodies: (4, 4) placements in the robot frame, mm, by body; the true ones of a simulation only.

    """

    number: int
    frame: Frame
    q_cmd: Array
    measured_px: dict[str, Array]
    twin_px: dict[str, Array] = field(default_factory=dict)
    twin_bodies: dict[str, Array] = field(default_factory=dict)
    true_bodies: dict[str, Array] = field(default_factory=dict)

    @cached_property
    def jpeg(self) -> bytes:
        """The picture for a page."""
        return _encoded(".jpg", self.frame.image, [cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY])

    @cached_property
    def png(self) -> bytes:
        """The picture without loss, for a program."""
        return _encoded(".png", self.frame.image, [cv2.IMWRITE_PNG_COMPRESSION, 1])

    def misses_mm(self, camera: Camera, plane_z_mm: float) -> dict[str, Array]:
        """(2,) measured less expected place of each marker in the robot's plane, mm; x_robot is -x_board."""
        common = [name for name in self.twin_px if name in self.measured_px]
        if not common:
            return {}
        seen = back_project(camera, np.array([self.measured_px[name] for name in common]), plane_z_mm)
        expected = back_project(camera, np.array([self.twin_px[name] for name in common]), plane_z_mm)
        miss = (seen - expected)[:, :2] * [-1.0, 1.0]
        return dict(zip(common, miss, strict=True))

    def miss(self, twin: str, arm: Arm, camera: Camera, plane_z_mm: float) -> Miss:
        """Return how far this pose was off."""
        misses = self.misses_mm(camera, plane_z_mm)
        tip = arm.marker_names[-1]
        place = self.twin_bodies[f"end{arm.n_joints}"][:2, 3]
        return Miss(
            twin=twin,
            q_cmd_rad=self.q_cmd.tolist(),
            tip_mm=place.tolist() if tip in misses else None,
            miss_mm=misses[tip].tolist() if tip in misses else None,
            worst_mm=max((float(np.linalg.norm(one)) for one in misses.values()), default=None),
        )


def _encoded(suffix: str, image: NDArray[np.uint8], options: list[int]) -> bytes:
    done, data = cv2.imencode(suffix, image, options)
    if not done:
        raise JobError("the picture cannot be encoded")
    return data.tobytes()
