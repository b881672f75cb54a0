"""What the lens shader is told of a camera, and how far from the axis its polynomial may be trusted."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armtwin.models.camera import Camera, normalise
from armtwin.models.errors import InputError

Array = NDArray[np.float64]

# OpenCV puts the centre of the first pixel at (0, 0), OpenGL at (0.5, 0.5).
HALF_PIXEL = 0.5


@dataclass(frozen=True, eq=False)
class Lens:
    """Uniform values of the lens shader.

    Attributes:
        K: (3, 3) camera matrix with OpenGL's pixel origin.
        radial: (3,) k1, k2, k3.
        tangential: (2,) p1, p2.
        linear_from: normalised radius beyond which the distortion is continued linearly.

    """

    K: Array
    radial: Array
    tangential: Array
    linear_from: float


def fold_radius(D: Array) -> float:
    """Return the normalised radius at which the radial polynomial r (1 + k1 r^2 + k2 r^4 + k3 r^6) turns back.

    Infinite where it never does. 0.657 for Table 2.
    """
    k1, k2, _, _, k3 = D
    roots = np.roots([7.0 * k3, 5.0 * k2, 3.0 * k1, 1.0])  # the derivative, in r^2
    real = roots[(np.abs(roots.imag) < 1e-12) & (roots.real > 0.0)].real
    return float(np.sqrt(real.min())) if real.size else float("inf")


def lens_of(camera: Camera) -> Lens:
    """Prepare a camera for the shader; raises InputError where its distortion folds back inside its own picture.

    Rays beyond the fold would land in the picture a second time. Nothing beyond the picture's corners is ever
    measured, so the polynomial is continued linearly from half way between the furthest corner and the fold.
    """
    fold = fold_radius(camera.D)
    w, h = camera.image_width - 0.5, camera.image_height - 0.5
    corners = np.array([[-0.5, -0.5], [w, -0.5], [-0.5, h], [w, h]])
    furthest = float(np.linalg.norm(normalise(camera, corners), axis=1).max())
    if not furthest < fold:
        raise InputError(
            f"the lens distortion {camera.D.tolist()} folds back at the normalised radius {fold:.3f}, inside the "
            f"{camera.image_width}x{camera.image_height} picture; check distortion_coefficients and camera_matrix"
        )
    K = camera.K.copy()
    K[:2, 2] += HALF_PIXEL
    linear_from = 0.5 * (furthest + fold) if np.isfinite(fold) else 1e6
    return Lens(K, camera.D[[0, 1, 4]], camera.D[[2, 3]], linear_from)
