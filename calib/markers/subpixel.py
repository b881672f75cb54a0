"""The default detector: sub-pixel edge points, a robust ellipse in the disc's own plane, the image of its centre.

The image of a circle's centre is not the centre of the circle's image, and a lens bends the outline besides. Where the
camera is known the edge points are therefore carried through lens and projection onto the disc's plane, where the
outline is a circle whose centre is what is sought; that centre is then projected back to raw pixels. Every plane
parallel to the board gives the same answer, so only the camera's orientation matters.
"""

from __future__ import annotations

import numpy as np

from armtwin.calib.markers.candidates import CandidateDisc, find_candidates, red_channel
from armtwin.calib.markers.disc import WHOLE, Array, DetectorConfig, Disc, Image, Mask
from armtwin.calib.markers.edges import EdgePoints, find_edges, first_edges, n_normals
from armtwin.calib.markers.ellipse import Ellipses, determinants, fit_ellipses, semi_axes
from armtwin.models.camera import Camera, back_project, project, project_jacobian, rays_of

# Relative difference of the semi-axes that is believed without evidence, one standard deviation: on the disc's plane
# an orientation 2 degrees off at a tilt of 10; in raw pixels of an unknown camera a disc seen 15 degrees askew.
_PRIOR_ON_PLANE, _PRIOR_IN_PIXELS = 0.005, 0.02
# Passes after the first, coarse one: each squares the remaining error of about half a blur. More are made while a disc
# still moves by more than this share of its blur, as a half hidden one does, whose first ellipse is poor. All but the
# last use every other normal.
_LEAST_PASSES, _MOST_PASSES, _STANDING_BLURS = 2, 6, 0.1
# What hides a part of an outline still bends its visible neighbours a little: standard deviation of a coordinate of the
# centre that is allowed for it, blurs. Found from straight covers at any angle and depth.
_SPILL_BLURS = 0.05
# Robust weight above which an edge point counts as seen.
_KEPT_WEIGHT = 0.3


def detect_subpixel(
    image: Image, camera: Camera | None = None, plane_z_mm: float = 0.0, config: DetectorConfig | None = None
) -> tuple[Disc, ...]:
    """Return the discs of a BGR or grey picture, from left to right; see `markers.detect`."""
    config = config or DetectorConfig()
    candidates = find_candidates(image, config)
    discs: list[Disc] = []
    red = red_channel(np.ascontiguousarray(image))
    small = [c for c in candidates if c.radius < 10.0]
    large = [c for c in candidates if c.radius >= 10.0]
    for group in (small, large):  # one number of normals a group
        if group:
            discs += _measure(red, group, camera, plane_z_mm, config)
    return tuple(sorted(_distinct(discs), key=lambda disc: float(disc.centre[0])))


def _distinct(discs: list[Disc]) -> list[Disc]:
    """Drop what lies on a better seen disc: the two sides of a cable across a disc are found as one disc each."""
    kept: list[Disc] = []
    for disc in sorted(discs, key=lambda d: -d.coverage * float(d.axes[0])):
        if all(np.linalg.norm(disc.centre - k.centre) > 0.7 * max(disc.axes[0], k.axes[0]) for k in kept):
            kept.append(disc)
    return kept


def _measure(
    red: Image, candidates: list[CandidateDisc], camera: Camera | None, plane_z_mm: float, config: DetectorConfig
) -> list[Disc]:
    centre = np.stack([c.centre for c in candidates])
    shape = np.stack([c.shape for c in candidates])
    normals = n_normals(max(c.radius for c in candidates))
    to_plane = _local_plane(camera, centre)
    edges = first_edges(red, centre, shape, normals // 2)
    for number in range(_MOST_PASSES):
        last = centre
        centre, shape = _refit(edges, centre, to_plane, camera)
        good = _plausible(edges, centre, shape, config)
        if not good.any():
            return []
        moved = np.linalg.norm(centre - last, axis=-1) > _STANDING_BLURS * edges.blur
        centre, shape, to_plane = centre[good], shape[good], to_plane[good]
        stands = number + 1 >= _LEAST_PASSES and not moved[good].any()
        is_last = stands or number + 1 == _MOST_PASSES
        edges = find_edges(
            red, centre, shape, normals if is_last else normals // 2, edges.blur[good], edges.noise[good]
        )
        if is_last:
            break
    return _discs(edges, centre, shape, camera, plane_z_mm, config)


def _local_plane(camera: Camera | None, centre: Array) -> Array:
    """(K, 2, 2) linear map of small pixel offsets about (K, 2) centres to the plane, up to scale.

    Identity without a camera, and where the lens has no ray for a centre.
    """
    if camera is None:
        return np.broadcast_to(np.eye(2), (len(centre), 2, 2))
    J = camera.K[:2, :2] @ camera.lens.jacobian(rays_of(camera, centre)) @ camera.R_board_camera[:, :2]
    J = np.where(np.isfinite(J).all(axis=(1, 2), keepdims=True), J, np.eye(2))
    return np.asarray(np.linalg.inv(J), dtype=np.float64)


def _refit(edges: EdgePoints, centre: Array, to_plane: Array, camera: Camera | None) -> tuple[Array, Array]:
    """Ellipse (centre, shape) in raw pixels through the edge points, held near a circle on the plane."""
    points = (edges.points - centre[:, None]) @ to_plane.transpose(0, 2, 1)
    fit = _fit(points, edges, camera, steps=2)
    to_pixels = np.asarray(np.linalg.inv(to_plane), dtype=float)
    return centre + (to_pixels @ fit.centre[..., None])[..., 0], to_pixels @ fit.shape


def _fit(points: Array, edges: EdgePoints, camera: Camera | None, steps: int) -> Ellipses:
    prior = _PRIOR_IN_PIXELS if camera is None else _PRIOR_ON_PLANE
    return fit_ellipses(points, edges.mask, prior, steps)


def _plausible(edges: EdgePoints, centre: Array, shape: Array, config: DetectorConfig) -> Mask:
    """(K,) which ellipses may be discs at all, so that the rest costs no further pass."""
    axes = semi_axes(shape)
    radius = np.sqrt(axes[:, 0] * axes[:, 1])
    good: Mask = (
        np.isfinite(centre).all(axis=-1)
        & (edges.mask.mean(axis=-1) >= 0.5 * config.min_coverage)
        & (edges.contrast >= config.min_contrast)
        & (radius >= config.min_radius_px)
        & (radius <= config.max_radius_px)
        & (axes[:, 1] > 0.5 * axes[:, 0])
    )
    return good


def _discs(
    edges: EdgePoints, centre: Array, shape: Array, camera: Camera | None, plane_z_mm: float, config: DetectorConfig
) -> list[Disc]:
    K, T, _ = edges.points.shape
    points = edges.points
    if camera is not None:
        points = back_project(camera, points.reshape(-1, 2), plane_z_mm)[:, :2].reshape(K, T, 2)
    fit = _fit(points, edges, camera, steps=3)
    centres, covariances = fit.centre, fit.covariance(_edge_std(fit, edges, shape))
    if camera is not None:
        on_plane = np.concatenate([fit.centre, np.full((K, 1), plane_z_mm)], axis=1)
        centres = project(camera, on_plane)
        J = project_jacobian(camera, on_plane)[..., :2]
        covariances = J @ covariances @ J.transpose(0, 2, 1)
    kept = fit.weights > _KEPT_WEIGHT
    coverage = kept.mean(axis=-1)
    spill = np.where(coverage < WHOLE, _SPILL_BLURS * edges.blur, 0.0)
    covariances = covariances + (edges.level_std**2 + spill**2)[:, None, None] * np.eye(2)
    axes = semi_axes(shape)
    chosen = _plausible(edges, centre, shape, config) & (coverage >= config.min_coverage)
    return [
        Disc(
            centre=centres[k],
            covariance=covariances[k],
            axes=axes[k],
            contrast=float(edges.contrast[k]),
            blur_px=float(edges.blur[k]),
            coverage=float(coverage[k]),
            edges=edges.points[k][kept[k]],
        )
        for k in np.flatnonzero(chosen)
    ]


def _edge_std(fit: Ellipses, edges: EdgePoints, shape: Array) -> Array:
    """(K,) standard deviation of one edge point, points' unit, the noise of all points taken as independent.

    The larger of what the pixels' noise gives and what the points scatter by: only the second knows of a wrong shape,
    but it sees too little of noise that neighbouring points share.
    """
    unit = np.sqrt(determinants(fit.shape) / determinants(shape))
    kept = fit.weights > 0.0
    scatter = np.sqrt((np.where(kept, fit.residuals, 0.0) ** 2).sum(axis=-1) / np.maximum(kept.sum(axis=-1) - 5, 1))
    larger: Array = np.maximum(edges.edge_std * unit, scatter)
    return larger
