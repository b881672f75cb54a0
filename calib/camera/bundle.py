"""Bundle adjustment: intrinsics of any lens, the board's bow and every view's pose, of least squared distance.

The poses are eliminated view by view (Schur complement; Triggs et al. 2000), so that a step costs as many small systems
as there are views. All slopes are the lens's own. A board that is not flat bows as mrcal's `calobject_warp` has it: a
parabola each way, nothing at its edges.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from armtwin.models.lenses import Lens

Array = NDArray[np.float64]

_STEPS = 60
_CLOSED = 1e-12  # relative decrease of the sum of squares that ends the iteration
_LARGEST_DAMPING = 1e9
FOCAL = ("fx", "fy", "cx", "cy")
BOW = ("bow_x_mm", "bow_y_mm")


@dataclass(frozen=True, eq=False)
class Bundle:
    """What is adjusted.

    Attributes:
        K: (3, 3) camera matrix, px.
        lens: the lens.
        poses: (V, 6) rotation vectors and translations, mm, board to camera.
        extent_mm: (2, 2) least and greatest x, y of the board's points.
        bow_mm: (2,) height of the board's middle over its edges, along x and along y; z of the board frame.

    """

    K: Array
    lens: Lens
    poses: Array
    extent_mm: Array
    bow_mm: Array

    @property
    def names(self) -> tuple[str, ...]:
        """Of the parameters that all views share."""
        return (*FOCAL, *self.lens.names, *BOW)

    @property
    def shared(self) -> Array:
        """(p,) values of the parameters that all views share."""
        K = self.K
        return np.array([K[0, 0], K[1, 1], K[0, 2], K[1, 2], *self.lens.coefficients, *self.bow_mm])

    def moved(self, shared: Array, poses: Array) -> Bundle:
        """Add (p,) to the shared parameters; turn and shift the (V, 6) poses about and along the camera's axes."""
        n = len(FOCAL)
        K = self.K.copy()
        K[[0, 1, 0, 1], [0, 1, 2, 2]] += shared[:n]
        new = [
            [*cv2.Rodrigues(cv2.Rodrigues(step[:3])[0] @ cv2.Rodrigues(pose[:3])[0])[0].ravel(), *(pose[3:] + step[3:])]
            for pose, step in zip(self.poses, poses, strict=True)
        ]
        return Bundle(K, self.lens.changed(shared[n:-2]), np.array(new), self.extent_mm, self.bow_mm + shared[-2:])


def free_names(lens: Lens, *, centre: bool = True, bow: bool = False) -> tuple[str, ...]:
    """Names of the shared parameters that a model adjusts: with or without the principal point, the board's bow."""
    focal = FOCAL if centre else FOCAL[:2]
    return (*focal, *lens.names, *(BOW if bow else ()))


def predict(bundle: Bundle, points: Array, view: int) -> Array:
    """(N, 2) pixels of a view's (N, 3) board points, mm."""
    X = _in_camera(bundle, points, view)
    return bundle.lens.project(X) @ bundle.K[:2, :2].T + bundle.K[:2, 2]


def slopes(bundle: Bundle, points: Array, view: int) -> tuple[Array, Array]:
    """(2 N, 6) derivative of a view's pixels by its pose, about the camera's axes, and (2 N, p) by what is shared."""
    X = _in_camera(bundle, points, view)
    A = bundle.K[:2, :2]
    by_ray = A @ bundle.lens.jacobian(X)
    t = bundle.poses[view, 3:]
    turned = X - t  # a small turn w about the camera's axes moves R x by w × R x
    by_pose = np.concatenate([np.cross(turned[:, None, :], by_ray), by_ray], axis=-1)
    place = bundle.lens.project(X)
    focal = np.zeros((len(X), 2, 4))
    focal[:, 0, 0], focal[:, 1, 1] = place[:, 0], place[:, 1]
    focal[:, 0, 2] = focal[:, 1, 3] = 1.0
    R = cv2.Rodrigues(bundle.poses[view, :3])[0]
    height = by_ray @ R[:, 2]
    bow = height[:, :, None] * _bows(bundle, points)[:, None, :]
    shared = np.concatenate([focal, A @ bundle.lens.coefficient_jacobian(X), bow], axis=-1)
    return by_pose.reshape(-1, 6), shared.reshape(2 * len(X), -1)


def residuals_of(bundle: Bundle, points: Sequence[Array], pixels: Sequence[Array]) -> list[Array]:
    """Measured less predicted pixels, (N, 2) of each view."""
    return [seen - predict(bundle, at, v) for v, (at, seen) in enumerate(zip(points, pixels, strict=True))]


def adjust(
    bundle: Bundle, points: Sequence[Array], pixels: Sequence[Array], free: Sequence[str], steps: int = _STEPS
) -> Bundle:
    """Adjust the shared parameters named in `free`, and all poses, by damped least squares.

    `points` are the (N, 3) board points, mm, of each view and `pixels` the (N, 2) places where they were seen.
    """
    chosen = np.array([bundle.names.index(name) for name in free], dtype=int)
    cost, damping = _cost(bundle, points, pixels), 1e-4
    for _ in range(steps):
        blocks = [_normal(bundle, points[v], pixels[v], v, chosen) for v in range(len(points))]
        gained = False
        while damping < _LARGEST_DAMPING:
            shared, poses = _step(blocks, damping, len(bundle.names), chosen)
            trial = bundle.moved(shared, poses)
            with np.errstate(all="ignore"):
                new = _cost(trial, points, pixels)
            if new < cost:
                gained, damping = True, damping * 0.1
                break
            damping *= 10.0
        if not gained:
            break
        ended = cost - new < _CLOSED * cost
        bundle, cost = trial, new
        if ended:
            break
    return bundle


def place_view(bundle: Bundle, points: Array, pixels: Array) -> Bundle:
    """Return the bundle with one view: the pose of a board of (N, 3) points seen at (N, 2) pixels, lens as it is.

    Raises:
        numpy.linalg.LinAlgError: the points determine no pose.

    """
    place = np.asarray(np.linalg.solve(bundle.K[:2, :2], (pixels - bundle.K[:2, 2]).T).T, dtype=np.float64)
    rays = bundle.lens.unproject(place)
    ahead = np.isfinite(rays).all(axis=1) & (rays[:, 2] > 0.05 * np.linalg.norm(rays, axis=1))
    if ahead.sum() < 4:
        raise np.linalg.LinAlgError("fewer than four points before the camera")
    xy = rays[ahead, :2] / rays[ahead, 2:]
    try:
        found, turns, shifts, _ = cv2.solvePnPGeneric(
            points[ahead], xy[:, None, :], np.eye(3), None, flags=cv2.SOLVEPNP_IPPE
        )
    except cv2.error as error:
        raise np.linalg.LinAlgError("no pose") from error
    starts = [np.append(turn, shift) for turn, shift in zip(turns[:found], shifts[:found], strict=True)]
    fits = [
        adjust(replace(bundle, poses=np.asarray(start, float)[None]), [points], [pixels], ())
        for start in starts
        if np.isfinite(start).all()
    ]
    if not fits:
        raise np.linalg.LinAlgError("no pose")
    return min(fits, key=lambda fit: _cost(fit, [points], [pixels]))


def _in_camera(bundle: Bundle, points: Array, view: int) -> Array:
    bowed = points
    if bundle.bow_mm.any():
        bowed = points.copy()
        bowed[:, 2] += _bows(bundle, points) @ bundle.bow_mm
    pose = bundle.poses[view]
    X: Array = bowed @ cv2.Rodrigues(pose[:3])[0].T + pose[3:]
    return X


def _bows(bundle: Bundle, points: Array) -> Array:
    """(N, 2) height of a bow of 1 along x, along y: 1 in the middle of the board, 0 at its ends."""
    low, high = bundle.extent_mm
    return np.asarray(1.0 - (2.0 * (points[:, :2] - low) / np.maximum(high - low, 1e-9) - 1.0) ** 2)


def _cost(bundle: Bundle, points: Sequence[Array], pixels: Sequence[Array]) -> float:
    total = sum(float(np.sum(r * r)) for r in residuals_of(bundle, points, pixels))
    return total if np.isfinite(total) else np.inf


def _normal(bundle: Bundle, points: Array, pixels: Array, view: int, chosen: NDArray[np.int_]) -> tuple[Array, ...]:
    by_pose, shared = slopes(bundle, points, view)
    shared = shared[:, chosen]
    residual = (pixels - predict(bundle, points, view)).ravel()
    return (
        by_pose.T @ by_pose,
        shared.T @ by_pose,
        shared.T @ shared,
        by_pose.T @ residual,
        shared.T @ residual,
    )


def _step(
    blocks: Sequence[tuple[Array, ...]], damping: float, size: int, chosen: NDArray[np.int_]
) -> tuple[Array, Array]:
    """(size,) step of what is shared and (V, 6) steps of the poses."""
    S, g, gains = np.zeros((len(chosen), len(chosen))), np.zeros(len(chosen)), []
    for C, B, A, gp, gs in blocks:
        gain = np.linalg.solve(C + damping * np.diag(np.diag(C)) + 1e-12 * np.eye(6), np.column_stack([B.T, gp]))
        S += A + damping * np.diag(np.diag(A)) - B @ gain[:, :-1]
        g += gs - B @ gain[:, -1]
        gains.append(gain)
    shared = np.zeros(size)
    step = np.zeros(0)
    if len(chosen):
        # Columns differ by ten orders of magnitude (px against k3): scale before solving.
        scale = 1.0 / np.sqrt(np.maximum(np.diag(S), 1e-30))
        step = scale * np.linalg.lstsq(S * np.outer(scale, scale), scale * g, rcond=1e-13)[0]
        shared[chosen] = step
    return shared, np.array([gain[:, -1] - gain[:, :-1] @ step for gain in gains])
