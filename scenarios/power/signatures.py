"""What every effect would move at its starts, worked out once for an arm: a fault's rivals are found by products.

One Gauss-Newton step from each start, as the diagnosis' screen takes it, but of an arm without a fault: what is left
of another arm's small fault is held against all starts at once. It says who may come near; those are then fitted.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from armtwin.calib.diagnosis.candidates import candidate_sites
from armtwin.calib.diagnosis.fit import Data, Fit
from armtwin.calib.diagnosis.linearisation import difference_step
from armtwin.calib.diagnosis.problem import Problem
from armtwin.models.catalogue.predict import Active, joint_angles
from armtwin.models.catalogue.registry import Effect, Stage
from armtwin.models.catalogue.site import Site

Array = NDArray[np.float64]
Pair = tuple[Effect, Site]

# Up to this departure of a joint the markers move in proportion to it.
LINEAR_RAD = 0.15


@dataclass(frozen=True, eq=False)
class _Start:
    """A start in the coordinates that the geometry cannot take up: its offset, and what its parameters move besides.

    `offset` (V,), `moves` (V, k), `inverse` (k, k) of their curvature, `pull` (k,) of the priors, `cost` of the offset.
    """

    pair: int
    offset: Array
    moves: Array
    inverse: Array
    pull: Array
    cost: float


class Signatures:
    """The starts of all effects at all places, on one arm without a fault."""

    def __init__(self, data: Data, base: Fit) -> None:
        self._counts = data.counts
        self._noise = data.noise
        pairs = candidate_sites(data)
        views = _Views(data, base)
        starts = [start for number, pair in enumerate(pairs) for start in views.starts(number, pair)]
        self._pairs, with_starts = pairs, {start.pair for start in starts}
        self._searched = [pair for number, pair in enumerate(pairs) if number not in with_starts]
        self._of = np.array([start.pair for start in starts])
        self._cost = np.array([start.cost for start in starts])
        self._offsets = np.stack([start.offset for start in starts])
        most = max(start.moves.shape[1] for start in starts)
        self._moves = np.zeros((len(starts), most, self._offsets.shape[1]))
        self._inverse = np.zeros((len(starts), most, most))
        self._pull = np.zeros((len(starts), most))
        for row, start in enumerate(starts):
            k = start.moves.shape[1]
            self._moves[row, :k] = start.moves.T
            self._inverse[row, :k, :k] = start.inverse
            self._pull[row, :k] = start.pull - start.moves.T @ start.offset

    def near(self, residual: Array, least: float, most: int, site: Site) -> list[Pair]:
        """Return up to `most` effects and places that promise to explain `least` of a residual (N, M, d), best first.

        Effects whose only starts are those that they find in the residual are always among them at `site`.
        """
        r = np.where(self._counts[..., None], residual, 0.0)[self._counts].reshape(-1) / self._noise
        r = np.nan_to_num(r)
        slope = self._moves @ r + self._pull
        gain = np.einsum("sk,skl,sl->s", slope, self._inverse, slope) + 2.0 * self._offsets @ r - self._cost
        best = np.full(len(self._pairs), -np.inf)
        np.maximum.at(best, self._of, gain)
        order = [int(k) for k in np.argsort(-best) if best[k] > least]
        return [*(self._pairs[k] for k in order[:most]), *(pair for pair in self._searched if pair[1] == site)]


class _Views:
    """Turns starts into what they move."""

    def __init__(self, data: Data, base: Fit) -> None:
        self._problem, self._counts, self._noise, self._g = data.problem, data.counts, data.noise, base.g
        self._q = joint_angles(self._problem.context, ())
        self._predicted, by_g = self._problem.predict_with_jacobian(base.g, ())
        self._by_joint = self._problem.jacobian_by_joint(base.g, self._q)
        J = by_g[self._counts].reshape(-1, by_g.shape[-1]) / self._noise
        self._J = J
        self._factor = linalg.cho_factor(J.T @ J + np.diag(self._problem.prior_std**-2.0))

    def starts(self, number: int, pair: Pair) -> Iterator[_Start]:
        """Yield the starts of an effect at a place."""
        effect, site = pair
        context = self._problem.context
        parameters = effect.parameters(context, site)
        for values in effect.starts(context, site, None):
            start = Active(effect, site, values)
            free = effect.acting(context, site, values)
            moved = self._moved(start)
            columns = np.empty((len(moved), len(free)))
            for column, k in enumerate(free):
                step = difference_step(parameters[k], values[k])
                ahead = values.copy()
                ahead[k] += step
                columns[:, column] = (self._moved(Active(effect, site, ahead)) - moved) / step
            precision = np.array([parameters[k].prior_std ** -2.0 for k in free])
            offset = np.array([parameters[k].pull(values[k]) for k in free])
            left, apart = self._beyond_geometry(moved), self._beyond_geometry(columns)
            curvature = columns.T @ apart + np.diag(precision)
            cost = float(moved @ left) + float((precision * offset * offset).sum())
            inverse = np.asarray(np.linalg.pinv(curvature, rcond=1e-12, hermitian=True), dtype=np.float64)
            yield _Start(number, left, apart, inverse, precision * offset, cost)

    def _beyond_geometry(self, columns: Array) -> Array:
        return np.asarray(columns - self._J @ linalg.cho_solve(self._factor, self._J.T @ columns))

    def _moved(self, active: Active) -> Array:
        """(V,) what an effect moves, in noises."""
        problem: Problem = self._problem
        if active.effect.stage <= Stage.JOINT:
            dq = joint_angles(problem.context, (active,)) - self._q
            if np.abs(dq).max() < LINEAR_RAD:
                return np.asarray(np.einsum("nmdj,nj->nmd", self._by_joint, dq)[self._counts].reshape(-1) / self._noise)
        moved = problem.predict(self._g, (active,)) - self._predicted
        return np.asarray(moved[self._counts].reshape(-1) / self._noise)
