"""An effect: parameters, model term, physical injector, what it is taken for and what tells it apart.

A prediction passes through the stages in this order; within a stage effects act in the order of `Stage`:

    commands --COMMAND--> what the servo receives --SERVO--> horn angles --JOINT--> link angles
             --> points of the markers --POINTS--> seen through --CAMERA--> pixels, maybe mis-detected --OBSERVATION-->

The model term explains an effect; the injector (`inject`) makes it in the simulated bench by physical means. The two
share no formula, so that recovering an injected effect proves something.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from enum import IntEnum
from typing import TYPE_CHECKING, Any, Protocol, cast

import numpy as np
from numpy.typing import NDArray

from armtwin.models.arm import Arm
from armtwin.models.camera import Camera
from armtwin.models.catalogue.camera_path import CameraPath
from armtwin.models.catalogue.context import Context
from armtwin.models.catalogue.evidence import Evidence
from armtwin.models.catalogue.found import Found
from armtwin.models.catalogue.injection import Injected, Stated, Where, checked, taken_by
from armtwin.models.catalogue.points import PointState
from armtwin.models.catalogue.sealed import Sealing
from armtwin.models.catalogue.site import NOWHERE, Site

if TYPE_CHECKING:  # what is built by MuJoCo, which a prediction does without
    from armtwin.models.world import World

Array = NDArray[np.float64]


class Stage(IntEnum):
    """Where along the prediction an effect acts."""

    COMMAND = 0
    SERVO = 1
    JOINT = 2
    POINTS = 3
    CAMERA = 4
    OBSERVATION = 5


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


class AngleTerm(Protocol):
    """A term of COMMAND, SERVO or JOINT."""

    def __call__(self, context: Context, q: Array, values: Array, site: Site, /) -> Array:
        """Return the joint angles (N, n), rad, that become of `q`, which stays as it is."""


class PointTerm(Protocol):
    """A term of POINTS."""

    def __call__(self, context: Context, state: PointState, values: Array, site: Site, /) -> PointState:
        """Return the markers' points as they are."""


class CameraTerm(Protocol):
    """A term of CAMERA."""

    def __call__(self, context: Context, path: CameraPath, values: Array, site: Site, /) -> CameraPath:
        """Return the camera as it stands."""


class Parameters(Protocol):
    """Declares the parameters of a term."""

    def __call__(self, context: Context, site: Site, /) -> tuple[Parameter, ...]:
        """Return them for a site."""


class Starts(Protocol):
    """Values from which a fit begins."""

    def __call__(self, context: Context, site: Site, around: Array | None, /) -> Iterable[Array]:
        """Return values (k,), scanned ones on a grid; `around` narrows the scan about an earlier best."""


class LeftByCalibration(Protocol):
    """Says how much of an effect a camera's calibration has left."""

    def __call__(self, assumed: Camera, true: Camera, /) -> dict[str, float]:
        """Return the term's values that lead from the camera as it was calibrated to the true one."""


class Injector(Protocol):
    """Makes an effect physically."""

    def __call__(self, world: World, parameters: Mapping[str, Any], site: Site, /) -> World:
        """Return the world with the effect in it, from parameters that were checked and completed."""


Term = AngleTerm | PointTerm | CameraTerm


def _no_parameters(context: Context, site: Site) -> tuple[Parameter, ...]:
    return ()


def _no_starts(context: Context, site: Site, around: Array | None) -> Iterable[Array]:
    return ()


@dataclass(frozen=True, kw_only=True)
class Effect:
    """One cause of error: fitted by its term, or (with `found`) found sample by sample.

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
        found: for an effect of single samples, which is found in the residuals instead of fitted.
        sealed: how it is hidden in a sealed world; None: it is not.
        gauge: for what no data of one plane can tell from the geometry, why, and what does: it is named there and is
            no cause.
        complexity: penalty, in deviance, of values where counting their parameters would not say it: some are idle.
        told: which of the values are told to people; the others are idle. None: all.
        needs_camera: it shows in pictures alone.
        needs_return: what it does follows the order of poses or the side they are approached from, so that where no
            joint ever turns back it is one with a joint's zero, gain or curve.
        in_time: it takes time; of causes that tie it is not named first where no time was recorded.
        as_gear: the injector's parameter by which a servo turns more than its command, where that is all it does: a
            model file may hold it as its actuator's gear.
        when_correcting: what the expectation of corrected commands leaves out of it, for people.
        left_by_calibration: how a calibrated camera's errors are told in its terms; None where they are none of it.

    """

    name: str
    summary: str
    where: Where
    stage: Stage
    injector: Injector
    injected: tuple[Injected, ...]
    confused_with: tuple[str, ...]
    experiment: str
    parameters: Parameters = _no_parameters
    term: Term | None = None
    starts: Starts = _no_starts
    applies: Callable[[Context, Site], str | None] = lambda context, site: None
    plans: tuple[str, ...] = ()
    physical: Callable[[Context, Array], dict[str, Any]] | None = None
    screen: Callable[[Context, Site, Evidence], Iterable[Array]] | None = None
    found: Found | None = None
    sealed: Sealing | None = None
    gauge: str | None = None
    complexity: Callable[[Context, Array], float] | None = None
    told: Callable[[Context, Array], list[int]] | None = None
    needs_camera: bool = False
    needs_return: bool = False
    in_time: bool = False
    as_gear: str | None = None
    when_correcting: str | None = None
    left_by_calibration: LeftByCalibration | None = None

    @property
    def angle_term(self) -> AngleTerm | None:
        """Its term where that acts on joint angles."""
        return cast(AngleTerm, self.term) if self.term is not None and self.stage <= Stage.JOINT else None

    @property
    def point_term(self) -> PointTerm | None:
        """Its term where that acts on the markers' points."""
        return cast(PointTerm, self.term) if self.term is not None and self.stage == Stage.POINTS else None

    @property
    def camera_term(self) -> CameraTerm | None:
        """Its term where that acts on the camera."""
        return cast(CameraTerm, self.term) if self.term is not None and self.stage == Stage.CAMERA else None

    @property
    def partner(self) -> str | None:
        """The injector's parameter that names another marker, of which this one may as well be the other."""
        return next((one.name for one in self.injected if one.kind == "marker"), None)

    @property
    def is_fitted(self) -> bool:
        """Whether its term is fitted, rather than its samples found."""
        return self.found is None and self.term is not None

    def why_not(self, context: Context, site: Site) -> str | None:
        """Say why it cannot be a cause in this recording, or None."""
        if self.gauge is not None:
            return self.gauge
        if self.needs_camera and context.camera is None:
            return "joint angles were measured, not pictures"
        return self.applies(context, site)

    def inject(self, world: World, parameters: Mapping[str, Any], site: Site = NOWHERE) -> World:
        """Return the `World` with this effect made in it; raises `InputError` as `check` does."""
        complete = self.check(Stated(parameters, site), world.arm)
        return self.injector(world, complete, site)

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

    def acting(self, context: Context, site: Site, values: Array) -> list[int]:
        """Return which of the values a gradient finds: neither scanned nor idle."""
        told = None if self.told is None else set(self.told(context, values))
        parameters = self.parameters(context, site)
        return [k for k, one in enumerate(parameters) if not one.scanned and (told is None or k in told)]

    def sites(self, context: Context) -> list[Site]:
        """List the sites at which this effect may sit in a recording."""
        if self.where in ("joint", "link"):
            return [Site(joint=joint + 1) for joint in range(context.arm.n_joints)]
        if self.where == "marker":
            return [Site(marker=name) for name in context.markers]
        return [Site()]
