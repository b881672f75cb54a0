"""Which disc is which marker: every assignment that the arm could make, with its misfit.

Squared standardised misfits add up over neighbouring markers that are seen (length of the link between them, size of
their discs) and over what is known besides (the command, the base). A marker taken as hidden costs as much as a misfit
of five standard deviations, so that a disc is left out rather than forced into place. What is known besides may itself
be wrong (a missed command, a bumped camera): its whole cost is capped, so that it decides between explanations that
the lengths allow and never against the only one.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from armtwin.calib.markers.disc import Array, Disc, Mask
from armtwin.models.arm import Arm
from armtwin.models.camera import Camera, back_project, project_jacobian
from armtwin.models.coordinate_frames import board_to_robot
from armtwin.models.kinematics import complex_links, marker_positions

Assignment = tuple[int | None, ...]

# What a link may differ from the drawing by, beyond which a disc is out of reach: Table 4's largest share of a length
# is 5.6 % (l1), and a plane 2.5 mm off scales all lengths by 0.5 %.
_LENGTH_SHARE, _LENGTH_MM = 0.06, 4.0
# Standard deviation of a link's place against its command: Table 4's zeros reach 4.8 degrees, and some mm at any angle.
_DIRECTION_RAD, _PLACE_MM = np.deg2rad(5.0), 2.0
# Of the base against where other pictures had it, mm: the camera may have been touched.
_BASE_MM = 4.0
# Of the logarithm of two discs' radii: they are printed alike.
_SIZE_LOG = 0.12
# Costs, in squared standard deviations.
HIDDEN_COST = 25.0
_COMMAND_CAP, _BASE_CAP, _SIZE_CAP = 30.0, 12.0, 60.0
# Explanations whose cost is within three standard deviations of the best are alike.
ALIKE = 9.0


@dataclass(frozen=True)
class Explanation:
    """One assignment: for each marker the index of its disc, or None where it is hidden; and its cost."""

    discs: Assignment
    cost: float


class Explainer:
    """Costs of assigning discs to an arm's markers.

    `q_cmd` (n,) rad and `base_hint_mm` (3,) board mm are used where they are given.
    """

    def __init__(
        self,
        discs: tuple[Disc, ...],
        arm: Arm,
        camera: Camera,
        plane_z_mm: float,
        q_cmd: Array | None = None,
        base_hint_mm: Array | None = None,
    ) -> None:
        self.n_markers = len(arm.marker_names)
        self._links = np.abs(complex_links(arm))
        pixels = np.array([d.centre for d in discs]).reshape(-1, 2)
        board = back_project(camera, pixels, plane_z_mm)
        self._known: Mask = np.asarray(np.isfinite(board).all(axis=1))
        self.places = board_to_robot(board, np.zeros(3))[:, :2]
        self._log_radius = _log_radii(discs, camera, board)
        predicted = None if q_cmd is None else marker_positions(arm, np.asarray(q_cmd, dtype=float)[None])[0]
        self._pairs = {pair: self._pair_costs(pair, predicted) for pair in combinations(range(self.n_markers), 2)}
        self._base = self._base_costs(base_hint_mm)

    def reach_mm(self, i: int, j: int) -> tuple[float, float]:
        """Least and largest distance of markers i < j, mm, tolerance included."""
        links = self._links[i:j]
        total, longest = float(links.sum()), float(links.max())
        slack = _LENGTH_MM + _LENGTH_SHARE * total
        return max(0.0, 2.0 * longest - total - slack), total + slack

    def _pair_costs(self, pair: tuple[int, int], predicted: Array | None) -> tuple[Array, Array]:
        """(M, M) cost of lengths and sizes, inf where out of reach, and of the command, for discs p, q of a pair."""
        i, j = pair
        between = self.places[None, :] - self.places[:, None]
        distance = np.sqrt((between**2).sum(axis=-1))
        low, high = self.reach_mm(i, j)
        size = np.minimum(((self._log_radius[None, :] - self._log_radius[:, None]) / _SIZE_LOG) ** 2, _SIZE_CAP)
        cost = np.nan_to_num(size)
        link_std = (_LENGTH_MM + _LENGTH_SHARE * float(self._links[i])) / 3.0
        if j == i + 1:
            cost += ((distance - self._links[i]) / link_std) ** 2
        else:
            # Over a hidden joint any distance within reach is as likely as another: what a chance hit costs more than
            # a link of the right length is twice the logarithm of the ratio of the two densities.
            cost += max(0.0, 2.0 * float(np.log((high - low) / (np.sqrt(2.0 * np.pi) * link_std))))
        # Two discs cannot lie upon one another, so a marker's own disc is no candidate for its neighbour.
        within = (distance >= max(low, 1.0)) & (distance <= high)
        cost = np.where(within & self._known[:, None] & self._known[None, :], cost, np.inf)
        command = np.zeros_like(distance)
        if predicted is not None:
            expected = predicted[j] - predicted[i]
            scale = _PLACE_MM + _DIRECTION_RAD * float(np.linalg.norm(expected))
            command = ((between - expected) ** 2).sum(axis=-1) / scale**2
        return cost, command

    def _base_costs(self, base_hint_mm: Array | None) -> list[Array]:
        """(M,) cost of each disc for each marker that is the first one seen, by the distance from the base."""
        if base_hint_mm is None:
            return [np.zeros(len(self.places)) for _ in range(self.n_markers)]
        base = board_to_robot(np.asarray(base_hint_mm, dtype=float), np.zeros(3))[:2]
        distance = np.sqrt(((self.places - base) ** 2).sum(axis=1))
        costs = [(distance / _BASE_MM) ** 2]
        for marker in range(1, self.n_markers):
            low, high = self.reach_mm(0, marker)
            outside = np.maximum(np.maximum(low - distance, distance - high), 0.0)
            # Anywhere within reach is as likely; again twice the logarithm of the ratio of the densities.
            costs.append((outside / _BASE_MM) ** 2 + 2.0 * float(np.log(high**2 / (2.0 * _BASE_MM**2))))
        return [np.minimum(cost, _BASE_CAP) for cost in costs]

    def explanations(self) -> list[Explanation]:
        """Return the explanations alike to the best one, best first."""
        best = [HIDDEN_COST * self.n_markers]  # of the explanation that sees nothing
        found = list(self._search((), None, 0.0, 0.0, best))
        return sorted((e for e in found if e.cost <= best[0] + ALIKE), key=lambda e: e.cost)

    def _search(
        self, chosen: Assignment, last: tuple[int, int] | None, cost: float, command: float, best: list[float]
    ) -> Iterator[Explanation]:
        """Depth first, discs before gaps; `last` is the last seen marker and its disc, `best` the least cost so far."""
        if cost + min(command, _COMMAND_CAP) > best[0] + ALIKE:
            return
        marker = len(chosen)
        if marker == self.n_markers:
            total = cost + min(command, _COMMAND_CAP)
            best[0] = min(best[0], total)
            yield Explanation(chosen, total)
            return
        for disc in range(len(self.places)):
            if disc in chosen or not self._known[disc]:
                continue
            if last is None:
                more, by_command = float(self._base[marker][disc]), 0.0
            else:
                costs, commands = self._pairs[last[0], marker]
                more, by_command = float(costs[last[1], disc]), float(commands[last[1], disc])
            if np.isfinite(more):
                yield from self._search((*chosen, disc), (marker, disc), cost + more, command + by_command, best)
        yield from self._search((*chosen, None), last, cost + HIDDEN_COST, command, best)


def _log_radii(discs: tuple[Disc, ...], camera: Camera, board: Array) -> Array:
    """(M,) logarithm of the discs' radii on the plane; NaN from a detector without uncertainty, whose sizes err."""
    if not discs:
        return np.empty(0)
    px_per_mm = np.sqrt(np.abs(np.linalg.det(project_jacobian(camera, board)[..., :2])))
    radius = np.array([np.sqrt(d.axes[0] * d.axes[1]) if np.isfinite(d.covariance).all() else np.nan for d in discs])
    logarithm: Array = np.log(radius / px_per_mm)
    return logarithm
