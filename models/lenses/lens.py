"""What a lens is: it maps rays in the camera's axes to places in the image, in focal lengths from the centre.

The camera matrix K, which all models share, makes pixels of those places (`models/camera.py`). A lens is a model and
its coefficients, as mrcal keeps them together; whoever needs a lens asks it, and nobody unpacks its coefficients.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Lens(ABC):
    """A lens model with its coefficients.

    Attributes:
        model: its name.
        names: of the coefficients, in the order of files.
        coefficients: (m,) their values.

    """

    model: ClassVar[str]
    names: ClassVar[tuple[str, ...]]
    coefficients: Array

    def __post_init__(self) -> None:
        """Refuse coefficients of another model: a programming error, files are checked before."""
        if np.shape(self.coefficients) != (len(self.names),):
            raise ValueError(f"{self.model} has {len(self.names)} coefficients, found {np.shape(self.coefficients)}")

    @abstractmethod
    def project(self, rays: Array) -> Array:
        """Map (..., 3) rays of any length, camera axes, to (..., 2) places in the image, focal lengths."""

    @abstractmethod
    def unproject(self, places: Array) -> Array:
        """Map (..., 2) places in the image to (..., 3) rays, the inverse of `project` to 1e-10; NaN without one."""

    @abstractmethod
    def jacobian(self, rays: Array) -> Array:
        """(..., 2, 3) derivative of `project` by its rays."""

    @abstractmethod
    def coefficient_jacobian(self, rays: Array) -> Array:
        """(..., 2, m) derivative of `project` by the coefficients."""

    @property
    @abstractmethod
    def limit_rad(self) -> float:
        """Angle from the axis up to which rays farther out land farther out; beyond it the model folds back."""

    @property
    def ros_model(self) -> str:
        """What ROS calls the model, in camera files and recordings."""
        return self.model

    @property
    def sensor(self) -> Array:
        """(3, 3) homography of places in the image where the sensor stands askew; identity for most lenses."""
        return np.eye(3)

    @property
    def named(self) -> dict[str, float]:
        """Each coefficient by its name."""
        return dict(zip(self.names, self.coefficients.tolist(), strict=True))

    def changed(self, change: Array) -> Self:
        """Return the lens with (m,) or (1,) added to its coefficients."""
        return replace(self, coefficients=self.coefficients + change)
