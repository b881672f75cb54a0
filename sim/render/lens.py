"""What the lens shader is told of a camera, and how far from the axis its lens may be trusted."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armtwin.models.camera import Camera, corner_angle_rad
from armtwin.models.errors import InputError
from armtwin.models.lenses import Equidistant

Array = NDArray[np.float64]

# OpenCV puts the centre of the first pixel at (0, 0), OpenGL at (0.5, 0.5).
HALF_PIXEL = 0.5
# Where a lens never folds, its model is followed this far: a tangent no picture reaches, and half a turn.
_FARTHEST_TANGENT = 1e6


@dataclass(frozen=True, eq=False)
class LensUniforms:
    """Uniform values of the lens shader.

    Attributes:
        K: (3, 3) camera matrix with OpenGL's pixel origin; a tilted sensor's homography is in it.
        fisheye: whether the radius grows with the angle from the axis instead of its tangent.
        radial: (4,) polynomial over the squared radius, from its linear coefficient on.
        divisor: (3,) the polynomial that divides it.
        tangential: (2,) p1, p2.
        prism: (4,) s1, s2, s3, s4.
        linear_from: normalised radius (of a fisheye: angle, rad) beyond which the lens is continued linearly.

    """

    K: Array
    fisheye: bool
    radial: Array
    divisor: Array
    tangential: Array
    prism: Array
    linear_from: float


def uniforms_of(camera: Camera) -> LensUniforms:
    """Prepare a camera for the shader; raises InputError where its lens folds back inside its own picture.

    Rays beyond the fold would land in the picture a second time. Nothing beyond the picture's corners is ever
    measured, so the lens is continued linearly from half way between the furthest corner and the fold.
    """
    lens = camera.lens
    furthest, fold = corner_angle_rad(camera), lens.limit_rad
    if not furthest < fold:
        raise InputError(
            f"the lens distortion {lens.coefficients.tolist()} ({lens.model}) folds back {np.degrees(fold):.1f} "
            f"degrees from the axis, inside the {camera.image_width}x{camera.image_height} picture; check "
            "distortion_coefficients and camera_matrix"
        )
    fisheye = isinstance(lens, Equidistant)
    if fisheye:
        linear_from = 0.5 * (furthest + fold)
    else:
        widest = np.tan(fold) if fold < 0.5 * np.pi else np.inf
        linear_from = float(min(0.5 * (np.tan(furthest) + widest), _FARTHEST_TANGENT))
    value = lens.named
    origin = np.array([[1.0, 0.0, HALF_PIXEL], [0.0, 1.0, HALF_PIXEL], [0.0, 0.0, 1.0]])
    return LensUniforms(
        K=origin @ camera.K @ lens.sensor,
        fisheye=fisheye,
        radial=np.array([value["k1"], value["k2"], value["k3"], value["k4"] if fisheye else 0.0]),
        divisor=np.array([0.0 if fisheye else value.get(name, 0.0) for name in ("k4", "k5", "k6")]),
        tangential=np.array([value.get(name, 0.0) for name in ("p1", "p2")]),
        prism=np.array([value.get(name, 0.0) for name in ("s1", "s2", "s3", "s4")]),
        linear_from=linear_from,
    )
