"""The twin that stands beside a served bench: a simulated arm that makes the same moves and sees nothing."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from armtwin.models.arm import Arm
from armtwin.models.camera import Camera, back_project, project
from armtwin.models.coordinate_frames import robot_to_board
from armtwin.models.twin import Twin, rebuild
from armtwin.models.world import World, ideal_world
from armtwin.sim.physics.simulation import ArmSimulation

Array = NDArray[np.float64]

# What a fault remembers of the past is a few moves; a twin that takes over makes the last ones again.
_REMEMBERED = 60


@dataclass(eq=False)
class TwinArm:
    """A twin by name; `drawn` at first, then what a calibration or a diagnosis found."""

    name: str
    world: World
    _arm: ArmSimulation = field(init=False)
    _moves: list[Array] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._arm = ArmSimulation(self.world)
        for sample, q in enumerate(self._moves[-_REMEMBERED:]):
            self._arm.move(q, sample)

    @classmethod
    def drawn(cls, arm: Arm, camera: Camera, plane_z_mm: float) -> TwinArm:
        """Return the twin of the drawing."""
        return cls("drawing", ideal_world(arm, camera, plane_z_mm))

    def replaced_by(self, name: str, twin: Twin) -> TwinArm:
        """Return another twin that has made the same moves."""
        return TwinArm(name, rebuild(twin), self._moves)

    def move(self, q: Array) -> None:
        """Move as the bench is moved, to (n,) rad."""
        self._moves.append(np.array(q))
        self._arm.move(q, len(self._moves) - 1)

    def bodies(self) -> dict[str, Array]:
        """(4, 4) placement of each body in the robot frame, mm."""
        return self._arm.bodies()

    def markers_px(self, camera: Camera, plane_z_mm: float, measured_px: dict[str, Array]) -> dict[str, Array]:
        """(2,) pixels of each marker; the arm's base stands where marker A, if it is found, is seen."""
        names, points = self._arm.marker_names, self._arm.markers_mm()
        base = self.world.base_in_board_mm
        first = names[0]
        if first in measured_px:
            base = back_project(camera, measured_px[first][None], plane_z_mm)[0]
            points = points - points[0] * [1.0, 1.0, 0.0]
        pixels = project(camera, robot_to_board(points, base))
        return dict(zip(names, pixels, strict=True))
