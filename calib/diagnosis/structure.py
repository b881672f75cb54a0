"""What a remainder follows: order, time, direction, angles, picture, torque. Noise follows nothing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from armtwin.calib.diagnosis.fit import Data, Fit, degrees_of_freedom
from armtwin.models.catalogue.context import Context

Array = NDArray[np.float64]

# Family-wise level over all tests of a remainder.
_LEVEL = 1e-3
# A trend that carries less than this share of the remainder's variance is no structure worth naming.
_LEAST_SHARE = 0.02
# One flipped step of a threshold effect outweighs a hundred poses, so the worst poses do not count in what is typical.
_WORST_POSES = 0.05


@dataclass(frozen=True)
class Trend:
    """How much of a remainder follows one thing: share of its variance, and how unlikely noise does that."""

    against: str
    share: float
    p_value: float


def trends(data: Data, model: Fit) -> list[Trend]:
    """Return what the remainder of `model` follows significantly, strongest first."""
    counts = data.counts
    r = np.where(counts[..., None], model.residual, np.nan) / data.noise
    found = []
    regressors = _regressors(data.problem.context, data, model)
    tests = len(regressors) + 2
    for name, columns in regressors.items():
        found.append(_regress(name, r, columns))
    found.append(_persistence(r, data.problem.context))
    if r.shape[1] > 1:
        found.append(_common_motion(r))
    kept = [t for t in found if t.p_value * tests < _LEVEL and t.share > _LEAST_SHARE]
    return sorted(kept, key=lambda trend: -trend.share)


def louder_than_noise(data: Data, model: Fit) -> Trend:
    """Return by how much a remainder exceeds the noise: declared, or seen in the differences of neighbouring poses."""
    free = degrees_of_freedom(data, model)
    misfit = float(model.misfit.sum())
    return Trend("the noise", max(0.0, 1.0 - free / misfit), float(stats.chi2.sf(misfit, free)))


def typical_misfit(misfit: Array, counts: NDArray[np.bool_], d: int) -> float:
    """Misfit to a value of (N, M) points of d values each, over all poses that count but the worst."""
    counted = counts.any(axis=1)
    poses = np.sort(misfit.sum(axis=1)[counted] / (d * counts.sum(axis=1)[counted]))
    return float(poses[: max(1, int(np.ceil(len(poses) * (1.0 - _WORST_POSES))))].mean())


def _regressors(context: Context, data: Data, model: Fit) -> dict[str, Array]:
    """(N, k) columns by what they stand for; `image position` is (N, M, k)."""
    order = np.linspace(-1.0, 1.0, len(context))
    out = {"order": np.stack([*(order**p for p in range(1, 5)), *_harmonics(np.pi * order, 3)], axis=-1)}
    if context.time_s is not None:
        clock = 2.0 * context.clock - 1.0
        out["time"] = np.stack([clock**p for p in range(1, 5)], axis=-1)
    moves = np.diff(context.q_cmd, axis=0, prepend=context.q_cmd[:1])
    out["direction of approach"] = np.sign(moves)
    for joint in range(context.arm.n_joints):
        q = context.q_cmd[:, joint]
        spread = (q - q.mean()) / max(float(np.abs(q - q.mean()).max()), 1e-9)
        out[f"angle of joint {joint + 1}"] = np.stack([*(spread**p for p in range(1, 4)), *_harmonics(q, 4)], axis=-1)
    out["trajectory"] = np.stack([context.trajectory == name for name in dict.fromkeys(context.trajectory)], -1) * 1.0
    if context.has_gravity:
        torque = context.declared_torque(context.q_cmd)
        out["gravity torque"] = torque / max(float(np.abs(torque).max()), 1e-12)
    if data.problem.is_pixels:
        seen = data.problem.predict(model.g, model.effects)
        assert context.camera is not None
        centre = np.array([context.camera.image_width, context.camera.image_height]) / 2.0
        u, v = np.moveaxis((seen - centre) / centre[0], -1, 0)
        out["image position"] = np.stack([u, v, u * u, u * v, v * v, u**3, v**3, u * u * v, u * v * v], axis=-1)
    return out


def _harmonics(angle: Array, count: int) -> list[Array]:
    return [wave(k * angle) for k in range(1, count + 1) for wave in (np.sin, np.cos)]


def _regress(name: str, r: Array, columns: Array) -> Trend:
    """F-test of every channel's components on the columns, pooled over channels."""
    explained = total = 0.0
    used = values = 0
    for channel in range(r.shape[1]):
        X = columns[:, channel] if columns.ndim == 3 else columns
        for component in range(r.shape[2]):
            y = r[:, channel, component]
            ok = np.isfinite(y)
            if ok.sum() < X.shape[1] + 4:
                continue
            A = np.column_stack([np.ones(ok.sum()), X[ok]])
            Q, R = np.linalg.qr(A)
            keep = np.abs(np.diag(R)) > 1e-8 * np.abs(R).max()
            Q = Q[:, keep]
            explained += float(((Q.T @ y[ok]) ** 2).sum())
            total += float((y[ok] ** 2).sum())
            used += int(keep.sum())
            values += int(ok.sum())
    free = values - used
    if free <= 0 or used == 0 or total <= 0:
        return Trend(name, 0.0, 1.0)
    left = max(total - explained, 1e-300)
    p = float(stats.f.sf((explained / used) / (left / free), used, free))
    # The share is adjusted for what pure noise would give to as many columns.
    return Trend(name, max(0.0, 1.0 - (left / free) / (total / values)), p)


def _persistence(r: Array, context: Context) -> Trend:
    """Correlation of a residual with the one before it, along the order of poses."""
    now, before = r[1:].reshape(-1), r[:-1].reshape(-1)
    ok = np.isfinite(now) & np.isfinite(before)
    if ok.sum() < 12 or now[ok].std() == 0 or before[ok].std() == 0:
        return Trend("the pose before", 0.0, 1.0)
    rho = float(np.corrcoef(now[ok], before[ok])[0, 1])
    return Trend("the pose before", rho * rho, float(2 * stats.norm.sf(abs(rho) * np.sqrt(ok.sum()))))


def _common_motion(r: Array) -> Trend:
    """Correlation of different markers (or joints) within one pose."""
    products, squares, pairs = 0.0, 0.0, 0
    for a in range(r.shape[1]):
        for b in range(a):
            both = np.isfinite(r[:, a]) & np.isfinite(r[:, b])
            products += float((r[:, a] * r[:, b])[both].sum())
            squares += float(np.sqrt((r[:, a][both] ** 2).sum() * (r[:, b][both] ** 2).sum()))
            pairs += int(both.sum())
    if pairs < 12 or squares == 0:
        return Trend("the same pose's other markers", 0.0, 1.0)
    rho = products / squares
    return Trend("the same pose's other markers", rho * rho, float(2 * stats.norm.sf(abs(rho) * np.sqrt(pairs))))
