"""What a term of the POINTS stage sees and returns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armtwin.models.catalogue.context import Context, nominal_links

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class Geometry:
    """The calibrated chain in the arm's plane.

    Attributes:
        base_mm: (2,) marker A's axis in the robot frame of the assumed base.
        links: (n,) complex link lengths, joint zeros included: link i points along links[i] times its direction.
        corner: complex position of the corner on the last link in its frame; 0 where it is not seen.

    """

    base_mm: Array
    links: Complex
    corner: complex = 0j


@dataclass(frozen=True, eq=False)
class PointState:
    """What a term of the POINTS stage sees: points (N, M, 3) mm, link directions (N, n), the geometry.

    The directions are those of the commands; `frames` are those of the links as they are built.
    """

    points_mm: Array
    directions: Complex
    geometry: Geometry

    def frames(self, context: Context) -> Complex:
        """(N, n) unit direction of each link's own frame, joint zeros included."""
        turned = self.geometry.links * np.conj(nominal_links(context.arm))
        out: Complex = self.directions * turned / np.maximum(np.abs(turned), 1e-12)
        return out
