"""Arm calibration by least squares in pixels on every measured marker, with analytic Jacobian and robust loss.

The fit goes in three steps: a robust linear start in the arm's plane; Gauss-Newton with Huber's loss in pixels; then,
with gross errors left out, plain least squares, whose covariance is exact for normal noise of unknown size. A prior as
wide as the drawing may be wrong (`Chain.spreads`) holds only what the data leave open; on what they know to 0.1 mm it
weighs 1e-5 of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.arm import joint_angles
from armtwin.calib.arm.calibration import ArmCalibration, Outlier
from armtwin.calib.arm.chain import BASE_NAMES, Chain
from armtwin.calib.arm.identifiability import analyse
from armtwin.calib.arm.observations import Observations, observe, rows_to_fit
from armtwin.calib.arm.start import start
from armtwin.models.camera import Camera, project, project_jacobian
from armtwin.models.errors import JobError
from armtwin.models.recordings.recording import Recording

Array = NDArray[np.float64]

# Finest noise that is believed, px: a hundredth of a good detector's. Keeps noiseless data well scaled.
NOISE_FLOOR_PX = 1e-3
# A distance in the plane with noise sigma on both axes has the median 1.1774 sigma.
_MEDIAN_DISTANCE = float(np.sqrt(2.0 * np.log(2.0)))
# Huber's loss turns linear here, in sigma of one coordinate.
_HUBER = 2.0
# Markers beyond this many sigma, six median distances, are left out. Normal pixel noise never does that (2e-11); the
# play of one joint, which moves a marker along a line, does it to one in twenty thousand.
_OUTLIER = 7.0
# Reweighting stops after this many steps, or when no parameter moves by more than a tenth of its standard deviation.
_REWEIGHTINGS, _NEARLY_AT_REST = 20, 0.1
# Plain least squares: from the robust fit it takes two or three steps; more than these is a failure.
_MAX_STEPS, _AT_REST = 50, 1e-4
# Rounds of leaving out and taking back; normally the second changes nothing.
_MAX_ROUNDS = 10


def calibrate(recording: Recording, trajectories: Sequence[str] | None = None) -> ArmCalibration:
    """Calibrate the arm on the named trajectories, by default on all that are not held out.

    Uses every seen marker in pixels; the base's x and y in the board frame are estimated along, its z is
    `arm_plane_z_mm`. A recording without markers is calibrated on its measured joint angles.
    Raises `InputError` for too few or collinear poses, or markers that say nothing about the arm.
    """
    rows = rows_to_fit(recording, trajectories)
    if not recording.markers_px or recording.camera is None or recording.arm_plane_z_mm is None:
        return joint_angles.calibrate(recording, rows)
    chain = Chain(recording.arm)
    seen = observe(recording, rows)
    problem = _Problem(chain, seen, recording.camera, recording.arm_plane_z_mm)
    fit = _solve(problem)
    return _report(recording, problem, fit)


@dataclass(frozen=True, eq=False)
class _Problem:
    """Residuals and Jacobian of K markers by the (P + 2) parameters: link parameters, then the base's x and y."""

    chain: Chain
    seen: Observations
    camera: Camera
    arm_plane_z_mm: float

    def residuals(self, x: Array) -> tuple[Array, Array]:
        """Return (K, 2) residuals, px, and the (K, 2, P + 2) derivative of the predicted pixels."""
        c, slope = self.chain.coefficients(x[:-2])
        w, moved = self.seen.directions @ c, self.seen.directions @ slope
        board = np.stack([x[-2] - w.real, x[-1] + w.imag, np.full(len(w), self.arm_plane_z_mm)], axis=-1)
        J_xy = project_jacobian(self.camera, board)[..., :2]
        J_links = J_xy[..., 1:] * moved.imag[:, None, :] - J_xy[..., :1] * moved.real[:, None, :]
        return self.seen.pixels - project(self.camera, board), np.concatenate([J_links, J_xy], axis=-1)

    def basis(self) -> Array:
        """(P + 2, P' + 2) basis of the parameters in the convention used."""
        links = self.chain.convention(self.seen.markers)
        out = np.zeros((len(links) + 2, links.shape[1] + 2))
        out[:-2, :-2] = links
        out[-2:, -2:] = np.eye(2)
        return out

    def precision(self) -> Array:
        """(P + 2, P + 2) inverse covariance of the drawing; none on the base."""
        return np.diag(np.concatenate([self.chain.spreads**-2.0, np.zeros(2)]))


@dataclass(frozen=True, eq=False)
class _Fit:
    """The parameters, their residuals and Jacobian, which of the K markers were used, and their noise, px."""

    x: Array
    residuals: Array
    J: Array
    used: NDArray[np.bool_]
    sigma: float
    degrees_of_freedom: int


def _solve(problem: _Problem) -> _Fit:
    basis = problem.basis()
    x = start(problem.chain, problem.seen, problem.camera, problem.arm_plane_z_mm)
    n_free = basis.shape[1]
    for _ in range(_REWEIGHTINGS):
        r, J = problem.residuals(x)
        distance = np.linalg.norm(r, axis=-1)
        sigma = _robust_sigma(distance, n_free)
        scale = _scales(problem.seen, distance, sigma, n_free)
        weight = np.minimum(1.0, _HUBER * scale / np.maximum(distance, NOISE_FLOOR_PX))
        x, moved = _step(problem, basis, x, r, J, weight, sigma)
        if moved < _NEARLY_AT_REST:
            break
    used = distance <= _OUTLIER * scale
    for _ in range(_MAX_ROUNDS):
        x, r, J = _plain(problem, basis, x, used, sigma)
        dof = max(2 * int(used.sum()) - n_free, 1)
        sigma = max(float(np.sqrt((r[used] ** 2).sum() / dof)), NOISE_FLOOR_PX)
        distance = np.linalg.norm(r, axis=-1)
        again = distance <= _OUTLIER * _scales(problem.seen, distance, sigma, n_free)
        if (again == used).all():
            break
        used = again
    return _Fit(x, r, J, used, sigma, dof)


def _plain(
    problem: _Problem, basis: Array, x: Array, used: NDArray[np.bool_], sigma: float
) -> tuple[Array, Array, Array]:
    """Gauss-Newton with step halving on the used markers to rest; returns parameters, residuals and Jacobian there."""
    weight, prior = used.astype(float), problem.precision()

    def cost(at: Array, residuals: Array) -> float:
        return float((residuals[used] ** 2).sum() / sigma**2 + at @ prior @ at)

    r, J = problem.residuals(x)
    for _ in range(_MAX_STEPS):
        ahead, moved = _step(problem, basis, x, r, J, weight, sigma)
        if moved < _AT_REST:
            return x, r, J
        new_r, new_J = problem.residuals(ahead)
        while cost(ahead, new_r) > cost(x, r) and moved >= _AT_REST:
            ahead, moved = (x + ahead) / 2.0, moved / 2.0
            new_r, new_J = problem.residuals(ahead)
        if moved < _AT_REST:
            return x, r, J
        x, r, J = ahead, new_r, new_J
    raise JobError(
        f"the arm calibration did not come to rest in {_MAX_STEPS} steps; the markers or commands of this recording "
        "contradict one another: look for swapped markers or shifted rows"
    )


def _step(
    problem: _Problem, basis: Array, x: Array, r: Array, J: Array, weight: Array, sigma: float
) -> tuple[Array, float]:
    """One weighted Gauss-Newton step; returns the parameters and the largest move in standard deviations."""
    flat = J.reshape(-1, J.shape[-1]) / sigma
    weighted = flat.T * np.repeat(weight, 2)
    prior = problem.precision()
    H = basis.T @ (weighted @ flat + prior) @ basis
    gradient = basis.T @ (weighted @ (r.ravel() / sigma) - prior @ x)
    step = _solve_normal(H, gradient)
    return x + basis @ step, float(np.abs(step * np.sqrt(np.diag(H))).max())


def _solve_normal(H: Array, right: Array) -> Array:
    """Solve normal equations whose unknowns have different units, each first scaled to one."""
    scale = 1.0 / np.sqrt(np.diag(H))
    scaled = np.linalg.solve(H * np.outer(scale, scale), (scale * right.T).T)
    return (scale * scaled.T).T


def _robust_sigma(distance: Array, n_free: int) -> float:
    """Noise of one coordinate from the median distance, corrected for the parameters that the fit has taken up."""
    lost = np.sqrt(1.0 - min(n_free / (2.0 * len(distance)), 0.5))
    middle = len(distance) // 2
    median = float(np.partition(distance, middle)[middle])  # numpy's median takes ten times as long on so few
    return max(median / (_MEDIAN_DISTANCE * float(lost)), NOISE_FLOOR_PX)


def _scales(seen: Observations, distance: Array, sigma: float, n_free: int) -> Array:
    """(K,) what is usual for each marker: the common noise, or its own where that is larger.

    Joint play and the like shake the far markers and leave A at rest: they are then no outliers.
    """
    own = [_robust_sigma(distance[seen.marker == number], n_free) for number in range(len(seen.markers))]
    return np.maximum(sigma, np.array(own))[seen.marker]


def _report(recording: Recording, problem: _Problem, fit: _Fit) -> ArmCalibration:
    seen, chain, basis = problem.seen, problem.chain, problem.basis()
    r, J = fit.residuals[fit.used], fit.J[fit.used]
    flat = J.reshape(-1, J.shape[-1]) / fit.sigma
    known = analyse(chain, flat, seen.markers, recording.q_cmd[np.unique(seen.row[fit.used])])
    prior = problem.precision()
    cov = _solve_normal(basis.T @ (flat.T @ flat + prior) @ basis, np.eye(basis.shape[1]))
    poses, pose = np.unique(seen.row[fit.used], return_inverse=True)
    scores = np.zeros((len(poses), basis.shape[1]))
    np.add.at(scores, pose, np.einsum("kip,ki->kp", J, r) @ basis / fit.sigma**2)
    scores *= np.sqrt(len(poses) / max(len(poses) - 1, 1))
    clustered = basis @ cov @ (scores.T @ scores + basis.T @ prior @ basis) @ cov @ basis.T
    mm = np.linalg.solve(J[:, :, -2:], r[..., None])[..., 0].astype(np.float64)
    left_out = [
        Outlier(
            int(recording.sample[seen.row[k]]), seen.markers[seen.marker[k]], float(np.linalg.norm(fit.residuals[k]))
        )
        for k in np.flatnonzero(~fit.used)
    ]
    return ArmCalibration(
        method="least-squares",
        deviation=chain.deviation(fit.x[:-2]),
        base_in_board_mm=np.array([fit.x[-2], fit.x[-1], problem.arm_plane_z_mm]),
        names=chain.names + BASE_NAMES,
        values=fit.x,
        covariance=basis @ cov @ basis.T,
        degrees_of_freedom=fit.degrees_of_freedom,
        clustered_std=np.sqrt(np.diag(clustered)),
        identifiable=known.identifiable,
        singular_values=known.singular_values,
        gauge=known.gauge,
        ties=known.ties,
        noise=fit.sigma,
        rms_px=_rms(r),
        rms_mm=_rms(mm),
        n_poses=len(poses),
        n_used=int(fit.used.sum()),
        outliers=tuple(sorted(left_out, key=lambda outlier: (outlier.sample, outlier.marker))),
    )


def _rms(vectors: Array) -> float:
    """Root mean square length of (K, 2) vectors."""
    return float(np.sqrt((vectors**2).sum(axis=-1).mean()))
