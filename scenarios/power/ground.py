"""What poses that nobody has run would show: of the geometry, of faults and their rivals, of the error on a path.

A fault's part that the geometry cannot take up is its likelihood distance (Ds-optimality); the part that neither the
geometry nor a rival takes up is what tells the two apart (T-optimality, A. Atkinson and V. Fedorov, Biometrika 62,
1975). A sequence of poses is judged as it is run: faults that remember depend on the order, the diagnosis holds every
fourth pose back, and a marker outside the picture is not seen.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from armtwin.calib.arm.observability import Observability, observability
from armtwin.calib.diagnosis.holdout import every_fourth
from armtwin.calib.diagnosis.problem import Problem, problem_of
from armtwin.models.catalogue.predict import Active, joint_angles
from armtwin.models.catalogue.registry import Stage, effect_named
from armtwin.models.catalogue.site import Site
from armtwin.scenarios.power.place import PlacePower
from armtwin.scenarios.power.power import Power
from armtwin.scenarios.power.setting import Setting, recording_without_noise
from armtwin.scenarios.power.signatures import LINEAR_RAD
from armtwin.scenarios.power.words import label

Array = NDArray[np.float64]

# Deviance that tells two causes apart beyond doubt: the ties' least difference, and twice the spread of such a one.
_TELLS = 30.0
_PERIOD_S = 2.0
_FROM = "from_sample"


@dataclass(frozen=True, eq=False)
class Fault:
    """A fault that a design is to show, as the diagnosis' term states it at the size found in 90 of 100."""

    name: str
    active: Active
    rivals: tuple[Active, ...] = ()


class Ground:
    """The arm, camera and noise of a setting; answers what any sequence of poses would show."""

    def __init__(self, setting: Setting, faults: Sequence[Fault], goal: Array | None = None) -> None:
        self.faults = tuple(faults)
        self.noise = setting.noise_px
        self._n = len(setting.plan)
        _, scene = setting.bench(np.random.default_rng(0), "gravity_sag")
        self._problem = problem_of(recording_without_noise(scene, scene.bench))
        self._goal = None if goal is None else self._tip_by_geometry(goal)

    def problem_at(self, q: Array) -> Problem:
        """Return the regression that a sequence of (N, n) commands would state."""
        n = len(q)
        context = replace(
            self._problem.context,
            q_cmd=q,
            time_s=_PERIOD_S * np.arange(n, dtype=np.float64),
            commanded_s=None,
            trajectory=np.full(n, "design"),
            payload_kg=np.zeros(n),
            temperature_c=None,
        )
        return replace(self._problem, context=context, observed=np.zeros((n, *self._problem.observed.shape[1:])))

    def is_seen(self, q: Array) -> NDArray[np.bool_]:
        """(N, M) whether the picture of the drawing's arm holds each marker."""
        problem = self.problem_at(q)
        camera = problem.context.camera
        assert camera is not None
        pixels = problem.predict(problem.nominal, ())
        return np.asarray(((pixels > 0) & (pixels < np.array([camera.image_width, camera.image_height]) - 1)).all(-1))

    def worth(self, q: Array, times: float = 1.0) -> Array:
        """What a sequence shows: a value for each fault, then each of its rivals, then the goal; see `wanted`.

        The faults are `times` as large as they are found in 90 of 100.
        """
        problem = self.problem_at(q)
        counts = self.is_seen(q) & ~every_fourth(len(q))[:, None]
        views = _Views(problem, counts, self.noise)
        shown = {
            id(active): views.beyond_geometry(_scaled(self._in_length(active, len(q)), problem, times))
            for fault in self.faults
            for active in (fault.active, *fault.rivals)
        }
        out = []
        for fault in self.faults:
            mine = shown[id(fault.active)]
            own = float(mine @ mine)
            out.append(own)
            for rival in fault.rivals:
                other = shown[id(rival)]
                shared = float(mine @ other) ** 2 / max(float(other @ other), 1e-12)
                out.append(max(own - shared, 0.0))
        if self._goal is not None:
            covariance = views.covariance
            out.append(1.0 / float(np.einsum("vg,gh,vh->", self._goal, covariance, self._goal) / len(self._goal)))
        return np.array(out)

    def wanted(self, reference: Array) -> Array:
        """What `worth` has to reach: a fault what it is worth on the plan that finds it, a rival what tells it."""
        told = reference.copy()
        place = 0
        for fault in self.faults:
            told[place + 1 : place + 1 + len(fault.rivals)] = _TELLS
            place += 1 + len(fault.rivals)
        return np.maximum(told, 1e-9)

    def fault_rows(self) -> list[int]:
        """Rows of `worth` that are the faults themselves."""
        sizes = [1 + len(fault.rivals) for fault in self.faults]
        return [int(k) for k in np.cumsum([0, *sizes[:-1]])] if sizes else []

    def indices(self, q: Array) -> Observability:
        """Return the observability of the geometry."""
        problem = self.problem_at(q)
        _, by_g = problem.predict_with_jacobian(problem.nominal, ())
        return observability(by_g[self.is_seen(q)].reshape(-1, by_g.shape[-1]) / self.noise, len(q))

    def path_error_mm(self, q: Array) -> float | None:
        """RMS error of a coordinate of the tip on the goal's path that the geometry's uncertainty leaves, mm."""
        return None if self._goal is None else float(1.0 / np.sqrt(self.worth(q)[-1]))

    def _in_length(self, active: Active, n: int) -> Active:
        """Return a fault whose events come at the same share of a sequence of `n` poses."""
        parameters = active.effect.parameters(self._problem.context, active.site)
        values = active.values.copy()
        for k, parameter in enumerate(parameters):
            if parameter.name.startswith(_FROM):
                values[k] = np.round(values[k] * n / self._n)
        return Active(active.effect, active.site, values)

    def _tip_by_geometry(self, q: Array) -> Array:
        """(2 K, g) derivative of the tip in the plane, mm, by the geometry along a path of (K, n) commands."""
        problem = self.problem_at(q)
        _, by_g = problem.predict_with_jacobian(problem.nominal, ())
        by_x, by_y = problem.pixels_by_plane(problem.nominal)
        plane = np.linalg.solve(np.stack([by_x, by_y], axis=-1)[:, -1], by_g[:, -1])
        return np.asarray(plane.reshape(-1, plane.shape[-1]))


class _Views:
    """What faults move of a sequence of poses, in noises, over what counts of it."""

    def __init__(self, problem: Problem, counts: NDArray[np.bool_], noise: float) -> None:
        self._problem, self._counts, self._noise = problem, counts, noise
        self._predicted, by_g = problem.predict_with_jacobian(problem.nominal, ())
        self._q = joint_angles(problem.context, ())
        self._by_joint = problem.jacobian_by_joint(problem.nominal, self._q)[counts]
        self._rows = np.nonzero(counts)[0]
        self._J = by_g[counts].reshape(-1, by_g.shape[-1]) / noise
        self._factor = linalg.cho_factor(self._J.T @ self._J + np.diag(problem.prior_std**-2.0))

    @property
    def covariance(self) -> Array:
        """(g, g) of the geometry."""
        return np.asarray(linalg.cho_solve(self._factor, np.eye(self._J.shape[1])))

    def beyond_geometry(self, active: Active) -> Array:
        """(V,) what the geometry cannot take up of what a fault moves."""
        moved = self._moved(active)
        return np.asarray(moved - self._J @ linalg.cho_solve(self._factor, self._J.T @ moved))

    def _moved(self, active: Active) -> Array:
        problem = self._problem
        if active.effect.stage <= Stage.JOINT:
            dq = joint_angles(problem.context, (active,)) - self._q
            if np.abs(dq).max() < LINEAR_RAD:
                return np.asarray((self._by_joint @ dq[self._rows][:, :, None]).reshape(-1) / self._noise)
        moved = problem.predict(problem.nominal, (active,)) - self._predicted
        return np.asarray(moved[self._counts].reshape(-1) / self._noise)


def _scaled(active: Active, problem: Problem, times: float) -> Active:
    """Return a fault some times as large: what vanishes with it grows, its shape stays."""
    if times == 1.0:
        return active
    values = active.values.copy()
    for k, one in enumerate(active.effect.parameters(problem.context, active.site)):
        if one.off is not None and not one.name.startswith(_FROM):
            values[k] = np.clip(one.off + times * (values[k] - one.off), *one.bounds)
    return Active(active.effect, active.site, values)


def faults_of(power: Power) -> list[Fault]:
    """Return the fitted faults that the plan of a power shows at some size, with the rivals that come near them."""
    context = Ground(power.setting, ()).problem_at(power.setting.plan.q_cmd).context
    shown = {(one.effect, one.site): _active(one) for one in power.places if one.estimates and one.size_90}
    out = []
    for one in power.places:
        active = shown.get((one.effect, one.site))
        if active is None or active.effect.why_not(context, active.site) is not None:
            continue
        near = [Site(*key[1:]) for key, _, _ in one.rivals]
        rivals = [shown.get((key[0], site)) for (key, _, _), site in zip(one.rivals, near, strict=True)]
        out.append(Fault(label(one.effect, one.site), active, tuple(r for r in rivals[:1] if r is not None)))
    return out


def _active(one: PlacePower) -> Active:
    return Active(effect_named(one.effect), one.site, np.array([value for value, _ in one.estimates.values()]))
