"""An effect: parameters, model term, physical injector, what it is taken for and what tells it apart.

A prediction passes through the stages in this order; within a stage effects act in the order of `Stage`:

    commands --COMMAND--> what the servo receives --SERVO--> horn angles --JOINT--> link angles
             --> points of the markers --POINTS--> seen through --CAMERA--> pixels, maybe mis-detected --OBSERVATION-->

The model term explains an effect; the injector (`inject`) makes it in the simulated bench by physical means. The two
share no formula, so that recovering an injected effect proves something.
"""

from __future__ import annotations

import importlib
import importlib.util
import pkgutil
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from enum import IntEnum
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from armtwin.models.arm import Arm
from armtwin.models.catalogue.context import Context
from armtwin.models.catalogue.injection import Injected, Stated, Where, checked, taken_by
from armtwin.models.errors import InputError, nearest, shown

Array = NDArray[np.float64]

# Departures of joints are no larger than about this, where nothing that was seen says more.
_PRIOR_RAD = 0.03


class Stage(IntEnum):
    """Where along the prediction an effect acts."""

    COMMAND = 0
    SERVO = 1
    JOINT = 2
    POINTS = 3
    CAMERA = 4
    OBSERVATION = 5


@dataclass(frozen=True)
class Site:
    """Where an effect sits: a joint, link or axis number counted from 1, a marker's name, or neither."""

    joint: int | None = None
    marker: str | None = None

    def __str__(self) -> str:
        if self.joint is not None:
            return f"joint {self.joint}"
        return f"marker {self.marker.upper()}" if self.marker else "whole arm"


@dataclass(frozen=True)
class Parameter:
    """A parameter of an effect.

    Attributes:
        name: with its unit, as it stands in every file.
        bounds: what is physically possible.
        prior_std: the physical prior's standard deviation in the parameter's unit.
        off: the value at which the effect vanishes, about which its prior stands; None for a parameter of shape, which
            means nothing while the effect is off and whose prior only damps its steps.
        scanned: the prediction is no smooth function of it, so it is found by a scan, not by a gradient.

    """

    name: str
    bounds: tuple[float, float]
    prior_std: float
    off: float | None = 0.0
    scanned: bool = False

    def pull(self, value: float) -> float:
        """Return how far the prior would move a value."""
        return 0.0 if self.off is None else self.off - value


# Model terms by stage: (context, input of the stage, parameter values, site) -> output of the stage.
Term = Callable[[Context, Any, Array, Site], Any]
# Finds single samples: (context, view of the residuals) -> sites with the values of what was found there.
Find = Callable[[Context, "View"], list[tuple["Site", Array]]]
# Starting values of the parameters, scanned ones on a grid; `around` narrows the scan about an earlier best.
Starts = Callable[[Context, Site, Array | None], Iterable[Array]]


@dataclass(frozen=True, eq=False)
class View:
    """Observed and predicted channels (N, M, d) (pixels of markers, or measured angles), NaN where not seen.

    `scale` is the robust standard deviation of what the present model leaves; `replay` tells what the model predicts
    for other commands (N, n).
    """

    observed: Array
    predicted: Array
    scale: float
    replay: Callable[[Array], Array] | None = None

    def misfit(self, observed: Array, predicted: Array) -> Array:
        """(...,) length of the residual in units of `scale`, NaN where not seen."""
        out: Array = np.linalg.norm(observed - predicted, axis=-1) / self.scale
        return out


@dataclass(frozen=True, eq=False)
class Evidence:
    """What a residual says of the joint angles: to add dq (N, n) changes the deviance by -2 pull dq + dq stiffness dq.

    `pull` is (N, n) per rad, `stiffness` (N, n, n) per rad^2; `commands` (N, n) are what the present model sends, rad.
    """

    pull: Array
    stiffness: Array
    commands: Array

    def departures(self, joint: int) -> tuple[Array, Array]:
        """(N,) departures, rad, that the residual shows of joint `joint` (from 0), and their weights, 1/rad^2.

        Where the markers that are seen do not tell the joints apart, all are taken to share the departure.
        """
        inverse = np.linalg.inv(self.stiffness + np.eye(self.pull.shape[1]) / _PRIOR_RAD**2)
        shown = np.einsum("nk,nk->n", inverse[:, joint], self.pull)
        weights = np.maximum(1.0 / inverse[:, joint, joint] - 1.0 / _PRIOR_RAD**2, 0.0)
        return shown, np.where(self.stiffness[:, joint, joint] > 0, weights, 0.0)

    def change(self, dq: Array) -> Array:
        """(S,) change of the deviance by each of S departures dq (S, N, n)."""
        linear = np.einsum("nj,snj->s", self.pull, dq)
        out: Array = np.einsum("snj,njk,snk->s", dq, self.stiffness, dq, optimize=True) - 2.0 * linear
        return out


@dataclass(frozen=True)
class Effect:
    """One cause of error.

    Attributes:
        name: its name in every file (design of the diagnosis).
        summary: one line for people.
        where: what it sits at.
        stage: where along the prediction its term acts.
        parameters: of its term, for a site.
        term: the estimator's explanation; None for an effect that is repaired in the observations instead.
        starts: values from which the fit begins.
        injector: makes the effect in a `World`, physically, from checked parameters: called by `inject`.
        injected: the parameters that the injector takes. A parameter of the term that is not among them says what a
            recording found the bench in (the side of a gap at its first pose), not what the bench is.
        confused_with: effects that some poses cannot tell from it.
        experiment: the poses that tell it apart, in words.
        applies: why it cannot be looked for in this recording, or None.
        plans: names of the experiments that the designer may propose for it.
        physical: turns the term's (or the finder's) values into the injector's parameters, where they are not the same
            by name.
        screen: starts that the residual of the joint angles suggests, where a grid would be too coarse or too long.
        find: for an effect of single samples, which is found in the residuals instead of fitted.
        complexity: penalty, in deviance, of values where counting their parameters would not say it: some are idle.
        told: which of the values are told to people; the others are idle. None: all.
        needs_return: what it does follows the order of poses or the side they are approached from, so that where no
            joint ever turns back it is one with a joint's zero, gain or curve.
        in_time: it takes time; of causes that tie it is not named first where no time was recorded.

    """

    name: str
    summary: str
    where: Where
    stage: Stage
    parameters: Callable[[Context, Site], tuple[Parameter, ...]]
    term: Term | None
    starts: Starts
    injector: Callable[..., Any]
    injected: tuple[Injected, ...]
    confused_with: tuple[str, ...]
    experiment: str
    applies: Callable[[Context, Site], str | None] = field(default=lambda context, site: None)
    plans: tuple[str, ...] = ()
    physical: Callable[[Context, Array], dict[str, Any]] | None = None
    screen: Callable[[Context, Site, Evidence], Iterable[Array]] | None = None
    find: Find | None = None
    complexity: Callable[[Context, Array], float] | None = None
    told: Callable[[Context, Array], list[int]] | None = None
    needs_return: bool = False
    in_time: bool = False

    def inject(
        self, world: Any, parameters: Mapping[str, Any], joint: int | None = None, marker: str | None = None
    ) -> Any:
        """Return the `World` with this effect made in it; raises `InputError` as `check` does."""
        complete = self.check(Stated(parameters, joint, marker), world.arm)
        return self.injector(world, complete, joint=joint, marker=marker)

    def check(self, stated: Stated, arm: Arm, n_poses: int | None = None) -> dict[str, Any]:
        """Return the injector's parameters with their defaults; raises `InputError` for what it cannot be given."""
        return checked(self.name, self.where, self.injected, stated, arm, n_poses)

    def built(self, context: Context, site: Site, values: Array) -> dict[str, Any]:
        """Return the term's values as the injector takes them."""
        if self.physical is not None:
            return self.physical(context, values)
        known = taken_by(self.injected, context.arm)
        pairs = zip(self.parameters(context, site), values, strict=True)
        return {parameter.name: float(value) for parameter, value in pairs if parameter.name in known}

    def sites(self, context: Context) -> list[Site]:
        """List the sites at which this effect may sit in a recording."""
        if self.where in ("joint", "link"):
            return [Site(joint=joint + 1) for joint in range(context.arm.n_joints)]
        if self.where == "marker":
            return [Site(marker=name) for name in context.markers]
        return [Site()]


_LOADED: dict[str, Effect] = {}


def catalogue() -> Mapping[str, Effect]:
    """Return every registered effect by name: one module of this package each, and those added by `register`."""
    if not _LOADED:
        package = importlib.import_module("armtwin.models.effects")
        for module in pkgutil.iter_modules(package.__path__):
            effect = getattr(importlib.import_module(f"armtwin.models.effects.{module.name}"), "EFFECT", None)
            if isinstance(effect, Effect):
                _LOADED[effect.name] = effect
    return _LOADED


def effect_named(name: str) -> Effect:
    """Return an effect; raises `InputError` with the nearest valid name."""
    known = catalogue()
    if name not in known:
        raise InputError(f"unknown effect '{shown(name)}'{nearest(name, known)}")
    return known[name]


def register(effect: Effect) -> None:
    """Add an effect from outside the package; raises `InputError` where the name is taken."""
    if effect.name in catalogue():
        raise InputError(f"effect '{effect.name}' is registered already; choose another name")
    _LOADED[effect.name] = effect


def register_file(path: Path) -> Effect:
    """Load a Python file that defines `EFFECT` and register it. The file is run: load only what you trust.

    Raises `InputError` where there is none, it does not run, or it defines no effect of a new name.
    """
    if not path.is_file():
        raise InputError(f"{path}: no such file; an effect is a Python file that defines EFFECT")
    spec = importlib.util.spec_from_file_location(f"armtwin_effect_{path.stem}", path)
    if spec is None or spec.loader is None:
        raise InputError(f"{path}: not a Python file; an effect is a Python file that defines EFFECT")
    module = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
    except (Exception, SystemExit) as error:  # somebody else's program: whatever it raises is its fault
        raise InputError(f"{path}: does not run: {type(error).__name__}: {error}") from error
    effect = getattr(module, "EFFECT", None)
    if not isinstance(effect, Effect):
        raise InputError(f"{path}: defines no EFFECT of type armtwin.models.catalogue.registry.Effect")
    from armtwin.models.catalogue.guard import guarded  # which knows the types of this module

    watched = guarded(effect, path)
    register(watched)
    return watched
