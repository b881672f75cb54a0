"""What one Gauss-Newton step promises for a candidate, at little more than the price of its predictions.

The geometry's Jacobian changes little by an effect, so that of the model under which the candidates are screened serves
all of them; the step in geometry and candidate together follows from it by the Schur complement. Effects that act on
joint angles alone are screened in joint space, where a pose is n numbers instead of all its pixels.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from armtwin.calib.diagnosis.fit import Data, Fit
from armtwin.calib.diagnosis.linearisation import difference_step
from armtwin.models.catalogue.predict import Active, joint_angles
from armtwin.models.catalogue.registry import Evidence, Parameter, Stage

Array = NDArray[np.float64]

# Up to this departure of a joint the markers move in proportion to it, to within a tenth.
_LINEAR_RAD = 0.15


class Screen:
    """Screens candidates on top of one fitted model."""

    def __init__(self, data: Data, base: Fit) -> None:
        self._data = data
        self._base = base
        problem, counts = data.problem, data.counts
        self._q = joint_angles(problem.context, base.effects)
        predicted, by_g = problem.predict_with_jacobian(base.g, base.effects)
        self._J = by_g[counts].reshape(-1, by_g.shape[-1]) / data.noise
        precision = problem.prior_std**-2.0
        self._factor = linalg.cho_factor(self._J.T @ self._J + np.diag(precision))
        self._pull = precision * (problem.nominal - base.g)
        self._prior = float((((base.g - problem.nominal) / problem.prior_std) ** 2).sum())
        # The same in joint space.
        residual = np.where(counts[..., None], problem.observed - predicted, 0.0) / data.noise
        by_joint = problem.jacobian_by_joint(base.g, self._q, base.effects)
        by_joint = np.where(counts[..., None, None], by_joint, 0.0) / data.noise
        by_g = np.where(counts[..., None, None], by_g, 0.0) / data.noise
        sent = [active for active in base.effects if active.effect.stage == Stage.COMMAND]
        self.evidence = Evidence(
            np.einsum("nmdj,nmd->nj", by_joint, residual),
            np.einsum("nmdj,nmdk->njk", by_joint, by_joint),
            joint_angles(problem.context, sent),
            0.0 if problem.is_pixels else problem.grain_std * float(np.sqrt(12.0)),
        )
        self._coupling = np.einsum("nmdg,nmdj->gnj", by_g, by_joint).reshape(by_g.shape[-1], -1)
        self._squares = float((residual * residual).sum())
        self._gradient = np.einsum("nmdg,nmd->g", by_g, residual) + self._pull

    def promise(self, candidate: Active) -> float:
        """Return the deviance that a fit from `candidate`'s values promises."""
        context = self._data.problem.context
        parameters = candidate.effect.parameters(context, candidate.site)
        free = candidate.effect.acting(context, candidate.site, candidate.values)
        if candidate.effect.stage <= Stage.JOINT:
            dq = self._turned(candidate)
            if np.abs(dq).max() < _LINEAR_RAD:
                return self._in_joint_space(candidate, parameters, free, dq)
        return self._in_channels(candidate, parameters, free)

    def _turned(self, candidate: Active) -> Array:
        return self._angles(candidate) - self._q

    def _angles(self, candidate: Active) -> Array:
        """(N, n) link angles with the candidate; what acts before it is not computed anew."""
        stage, context = candidate.effect.stage, self._data.problem.context
        if stage > Stage.JOINT:
            return self._q
        acting = [active.effect.stage for active in self._base.effects if active.effect.stage <= Stage.JOINT]
        if candidate.effect.angle_term is not None and all(stage >= earlier for earlier in acting):
            return candidate.effect.angle_term(context, self._q, candidate.values, candidate.site)
        return joint_angles(context, (*self._base.effects, candidate))

    def _in_joint_space(
        self, candidate: Active, parameters: Sequence[Parameter], free: Sequence[int], dq: Array
    ) -> float:
        pull, stiffness = self.evidence.pull, self.evidence.stiffness
        slopes = np.empty((len(free), *dq.shape))
        for row, k in enumerate(free):
            moved, step = _stepped(candidate, parameters, k)
            slopes[row] = (self._turned(moved) - dq) / step
        held = np.einsum("njk,nk->nj", stiffness, dq)
        left = pull - held
        stiff = np.einsum("njk,snk->snj", stiffness, slopes)
        squares = self._squares - float((dq * (pull + left)).sum())
        gradient = self._gradient - self._coupling @ dq.ravel()
        flat = slopes.reshape(len(free), dq.size)
        cross = self._coupling @ flat.T
        return self._promised(
            candidate,
            parameters,
            free,
            squares,
            gradient,
            cross,
            flat @ stiff.reshape(len(free), dq.size).T,
            flat @ left.ravel(),
        )

    def _in_channels(self, candidate: Active, parameters: Sequence[Parameter], free: Sequence[int]) -> float:
        problem, base = self._data.problem, self._base
        start = problem.predict(base.g, (*base.effects, candidate), self._angles(candidate))
        r = self._values(problem.observed - start)
        columns = np.empty((len(r), len(free)))
        for column, k in enumerate(free):
            moved, step = _stepped(candidate, parameters, k)
            shifted = problem.predict(base.g, (*base.effects, moved), self._angles(moved))
            columns[:, column] = self._values((shifted - start) / step)
        gradient = self._J.T @ r + self._pull
        return self._promised(
            candidate, parameters, free, float(r @ r), gradient, self._J.T @ columns, columns.T @ columns, columns.T @ r
        )

    def _promised(
        self,
        candidate: Active,
        parameters: Sequence[Parameter],
        free: Sequence[int],
        squares: float,
        gradient: Array,
        cross: Array,
        curvature: Array,
        slope: Array,
    ) -> float:
        """Deviance after the joint step: of the geometry first, then of the candidate's part that it cannot take up."""
        deviance = squares + self._prior - float(gradient @ linalg.cho_solve(self._factor, gradient))
        if not free:
            return deviance
        precision = np.array([parameters[k].prior_std ** -2.0 for k in free])
        offset = np.array([parameters[k].pull(candidate.values[k]) for k in free])
        reduced = linalg.cho_solve(self._factor, cross)
        schur = curvature - cross.T @ reduced + np.diag(precision)
        pull = slope + precision * offset - reduced.T @ gradient
        gain = float(pull @ np.linalg.lstsq(schur, pull, rcond=1e-12)[0])
        return deviance + float((precision * offset * offset).sum()) - gain

    def _values(self, channels: Array) -> Array:
        out: Array = channels[self._data.counts].reshape(-1) / self._data.noise
        return out


def _stepped(candidate: Active, parameters: Sequence[Parameter], k: int) -> tuple[Active, float]:
    """Return the candidate with one parameter moved a little, and by how much."""
    step = difference_step(parameters[k], candidate.values[k])
    values = candidate.values.copy()
    values[k] += step
    return Active(candidate.effect, candidate.site, values), step


def best_start(screen: Screen, candidates: Sequence[Active]) -> tuple[float, Active] | None:
    """Return promised deviance and candidate of the best start, or None where there is none."""
    promised = [(screen.promise(candidate), index) for index, candidate in enumerate(candidates)]
    if not promised:
        return None
    deviance, index = min(promised)
    return deviance, candidates[index]
