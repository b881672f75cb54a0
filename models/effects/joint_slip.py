"""A horn that slips: a zero that jumps at one sample, or again at others.

Known forms: a horn whose spline or set screw gives under a knock or a heavy move, once or again and again (a hobby
servo's spline has 25 teeth); a belt or a gear that skips a tooth, and skips back; a horn that creeps under load.
Covered: up to four jumps of a joint, each by its own angle, back among them. Not covered: more jumps, and a slip that
goes on while the arm moves (a slow one is taken for `thermal_drift`, a fast one is `unknown`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import mujoco
import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from armtwin.models.catalogue import sealed
from armtwin.models.catalogue.context import Context
from armtwin.models.catalogue.injection import Injected, sample
from armtwin.models.catalogue.jumps import jumps
from armtwin.models.catalogue.motion_effect import MotionEffect, Slot
from armtwin.models.catalogue.registry import Effect, Evidence, Parameter, Site, Stage
from armtwin.models.catalogue.scan import event_rows, since
from armtwin.models.motion_world import MotionWorld, Slip
from armtwin.models.world import Event, World, joint_index

Array = NDArray[np.float64]

_MOST_SLIPS = 4


def term(context: Context, q: Array, values: Array, site: Site) -> Array:
    """Angles whose zero jumps by each `jump_rad` at its `from_sample`; one beyond the last row never comes."""
    assert site.joint is not None
    out = q.copy()
    for jump, from_sample in values.reshape(-1, 2):
        out[:, site.joint - 1] += jump * since(context, from_sample)
    return out


def complexity(context: Context, values: Array) -> float:
    """Of each slip that comes: the logarithm of the rows for its size, twice that for its sample."""
    return 3.0 * float(np.log(len(context))) * len(_slips(context, values))


def physical(context: Context, values: Array) -> dict[str, Any]:
    """Return the slips that come as the simulated bench takes them."""
    built: dict[str, Any] = {}
    for number, (jump, row) in enumerate(_slips(context, values), start=1):
        built |= {_named("jump", number, "_rad"): float(jump), _named("from_sample", number): float(row)}
    return built or {"jump_rad": 0.0, "from_sample": 0.0}


def told(context: Context, values: Array) -> list[int]:
    """Return which values are of slips that come."""
    return [k for k in range(len(values)) if values[k | 1] < len(context)]


def _slips(context: Context, values: Array) -> list[Array]:
    return [slip for slip in values.reshape(-1, 2) if slip[1] < len(context)]


def _named(what: str, number: int, unit: str = "") -> str:
    return f"{what}{number if number > 1 else ''}{unit}"


def _parameters(context: Context, site: Site) -> tuple[Parameter, ...]:
    never = float(len(context))
    return tuple(
        parameter
        for number in range(1, _MOST_SLIPS + 1)
        for parameter in (
            Parameter(_named("jump", number, "_rad"), (-np.pi, np.pi), 0.3),
            Parameter(_named("from_sample", number), (1.0, never), never, off=never, scanned=True),
        )
    )


def _starts(context: Context, site: Site, around: Array | None) -> Iterable[Array]:
    """Return single slips here and there; `_screen` finds where the joint slipped."""
    if around is not None:
        return []
    return [_padded(context, [(row, 0.0)]) for row in event_rows(context, None)[::4]]


def _screen(context: Context, site: Site, evidence: Evidence) -> Iterable[Array]:
    """Return the jumps that the joint's departures show."""
    assert site.joint is not None
    found = jumps(*evidence.departures(site.joint - 1), _MOST_SLIPS)
    return [_padded(context, found)] if found else []


def _padded(context: Context, slips: list[tuple[int, float]] | list[tuple[float, float]]) -> Array:
    values = np.tile([0.0, float(len(context))], (_MOST_SLIPS, 1))
    for k, (row, jump) in enumerate(slips):
        values[k] = np.clip(jump, -np.pi, np.pi), row
    return values.ravel()


# --- how the simulated bench makes it ---


def inject(world: World, parameters: Mapping[str, Any], site: Site) -> World:
    """Turn link `joint` on its horn by `jump_rad`, about the axis, just before sample `from_sample`.

    `jump2_rad` at `from_sample2`, and so on, are turns on top of that.
    """
    number = joint_index(world, site) + 1
    for k in range(1, _MOST_SLIPS + 1):
        jump, start = parameters.get(_named("jump", k, "_rad")), parameters.get(_named("from_sample", k))
        if jump is not None and start is not None:
            world = world.with_event(Event(int(start), _slip(number, float(jump))))
    return world


def _slip(number: int, jump: float) -> Callable[[mujoco.MjModel, mujoco.MjData], None]:
    def slip(model: mujoco.MjModel, data: mujoco.MjData) -> None:
        link, turn, seat = model.body(f"link{number}"), np.zeros(4), np.zeros(4)
        mujoco.mju_axisAngle2Quat(turn, model.joint(f"joint{number}").axis, jump)
        mujoco.mju_mulQuat(seat, link.quat, turn)
        link.quat = seat

    return slip


def _hide(rng: Generator, s: sealed.Situation) -> sealed.Hidden:
    """Draw a slip, and sometimes others after it, or the way back."""
    start = sealed.event(rng, s)
    shares, rows = [sealed.sign(rng)], [start]
    form = rng.random()
    if form > 0.5:  # again, from one sample in twelve on
        apart = max(3, round(s.n_poses / 12))
        rows.append(min(start + int(rng.integers(apart, 3 * apart)), round(0.9 * s.n_poses)))
        shares.append(-shares[0] if form > 0.75 else sealed.sign(rng) * float(rng.uniform(0.6, 1.2)))
    names = [(f"jump{k or ''}_rad", f"from_sample{k or ''}") for k in (0, 2)]

    def parameters(a: float) -> dict[str, Any]:
        slips = zip(names, shares, rows, strict=False)
        return {key: value for (jump, row), share, at in slips for key, value in ((jump, share * a), (row, at))}

    return sealed.Hidden(parameters, 0.01, 0.3, sealed.any_joint(rng, s))


EFFECT = Effect(
    name="joint_slip",
    summary="a horn that slips: a zero that jumps at one sample, or at several",
    where="joint",
    stage=Stage.JOINT,
    parameters=_parameters,
    term=term,
    starts=_starts,
    injector=inject,
    injected=(
        Injected("jump_rad", (-np.pi, np.pi)),
        sample("from_sample"),
        *(Injected(f"jump{k}_rad", (-np.pi, np.pi), optional=True) for k in range(2, _MOST_SLIPS + 1)),
        *(Injected(f"from_sample{k}", optional=True, kind="sample") for k in range(2, _MOST_SLIPS + 1)),
    ),
    confused_with=("thermal_drift", "camera_moved"),
    experiment="the poses of the beginning once more",
    plans=("repeat_pose",),
    physical=physical,
    screen=_screen,
    complexity=complexity,
    told=told,
    needs_return=True,
    sealed=sealed.Sealing(_hide),
)


def inject_in_motion(world: MotionWorld, parameters: Mapping[str, Any], site: Site) -> MotionWorld:
    """Turn link `joint` on its horn by `jump_rad` at `from_s`."""
    (index,) = world.joints_at(site)
    return world.with_slip(Slip(index, float(parameters["from_s"]), float(parameters["jump_rad"])))


IN_MOTION = MotionEffect(
    name=EFFECT.name,
    summary=EFFECT.summary,
    where="joint",
    forms=(
        (
            Slot("jump_rad", "slip_rad", (-1.6, 1.6), (0.0,), 0.002),
            Slot("from_s", "slip_s", (0.0, 1e9), (), 0.05, scanned=True),
        ),
    ),
    confused_with=("thermal_drift", "missed_command"),
    experiment=EFFECT.experiment,
    motions=("holds", "steps"),
    injector=inject_in_motion,
    injected=(Injected("jump_rad", (-np.pi, np.pi)), Injected("from_s", (-1e18, 1e18))),
)
