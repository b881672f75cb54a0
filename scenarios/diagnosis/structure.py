"""Where to look: of every way to plot a remainder, the one in which it is least like noise."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.diagnosis.diagnosis import Diagnosis
from armtwin.scenarios.diagnosis.remainder import Remainder

Array = NDArray[np.float64]

# Poses are averaged in so many groups of equal size.
_GROUPS = 12
_LEAST_POSES = 8
# Moves below this are none.
_STILL_RAD = 1e-6
DIRECTIONS = {-1: "from above", 1: "from below"}


@dataclass(frozen=True, eq=False)
class Ordinate:
    """(N,) something that a remainder is plotted against; `is_direction` where it is -1 or 1."""

    against: str
    title: str
    values: Array
    is_direction: bool = False


@dataclass(frozen=True, eq=False)
class Component:
    """(N,) one signed part of a remainder, before and after (None where the twin was not extended).

    `unit_mm` is how many millimetres one of its unit makes at the tip.
    """

    title: str
    before: Array
    after: Array | None
    unit_mm: float = 1.0


@dataclass(frozen=True, eq=False)
class ResidualPlot:
    """The most telling plot against one thing, the share of the component's variance that follows it, and how much."""

    ordinate: Ordinate
    component: Component
    share_before: float
    share_after: float | None
    follows_mm: float


def residual_plots(diagnosis: Diagnosis, before: Remainder, after: Remainder | None) -> list[ResidualPlot]:
    """Return for each thing the component that follows it most, the most telling first."""
    components = list(_components(diagnosis, before, after))
    best: dict[str, ResidualPlot] = {}
    for ordinate in _ordinates(diagnosis):
        for component in components:
            shown = _residual_plot(ordinate, component)
            if ordinate.against not in best or shown.follows_mm > best[ordinate.against].follows_mm:
                best[ordinate.against] = shown
    return sorted(best.values(), key=lambda shown: -shown.follows_mm)


def _residual_plot(ordinate: Ordinate, component: Component) -> ResidualPlot:
    share = share_of_groups(ordinate, component.before)
    follows = float(np.sqrt(share * np.nanvar(component.before))) * component.unit_mm
    share_after = None if component.after is None else share_of_groups(ordinate, component.after)
    return ResidualPlot(ordinate, component, share, share_after, follows)


def groups_of(ordinate: Ordinate, seen: NDArray[np.bool_]) -> list[NDArray[np.int64]]:
    """Return the rows of each group of seen poses, in ascending order of the ordinate."""
    rows = np.flatnonzero(seen & np.isfinite(ordinate.values))
    if ordinate.is_direction:
        split = [rows[ordinate.values[rows] == side] for side in DIRECTIONS]
    else:
        ordered = rows[np.argsort(ordinate.values[rows], kind="stable")]
        split = np.array_split(ordered, min(_GROUPS, max(len(rows) // 4, 1)))
    return [group for group in split if len(group)]


def share_of_groups(ordinate: Ordinate, component: Array) -> float:
    """Share of a component's variance that the groups' means carry, less what noise would give to as many groups."""
    seen = np.isfinite(component)
    groups = groups_of(ordinate, seen)
    values = component[np.concatenate(groups)] if groups else np.zeros(0)
    free = len(values) - len(groups)
    if len(values) < _LEAST_POSES or free <= 0 or values.var() == 0:
        return 0.0
    within = sum(float(((component[group] - component[group].mean()) ** 2).sum()) for group in groups)
    return max(0.0, 1.0 - within / free / (float(((values - values.mean()) ** 2).sum()) / (len(values) - 1)))


def _ordinates(diagnosis: Diagnosis) -> Iterator[Ordinate]:
    context = diagnosis.problem.context
    numbers = np.arange(len(context), dtype=float)
    yield Ordinate("order", "pose, in the order they happened", numbers)
    if context.time_s is not None:
        yield Ordinate("time", "time, s", context.elapsed_s)
    moves = np.diff(context.q_cmd, axis=0, prepend=context.q_cmd[:1])
    torque = context.declared_torque(context.q_cmd) if context.has_gravity else None
    for joint in range(context.arm.n_joints):
        label = f"joint {joint + 1}"
        yield Ordinate(
            "direction of approach", f"{label} was approached", _last_turn(moves[:, joint]), is_direction=True
        )
        yield Ordinate(f"angle of {label}", f"commanded angle of {label}, °", np.degrees(context.q_cmd[:, joint]))
        if torque is not None:
            yield Ordinate("gravity torque", f"gravity's torque about {label}, N m", torque[:, joint])
    if diagnosis.problem.is_pixels:
        tip = context.markers[-1].upper()
        for axis, name in enumerate("uv"):
            yield Ordinate("image position", f"{name} of marker {tip}, px", diagnosis.problem.observed[:, -1, axis])


def _components(diagnosis: Diagnosis, before: Remainder, after: Remainder | None) -> Iterator[Component]:
    context = diagnosis.problem.context
    beyond_mm = np.cumsum(np.abs(context.links)[::-1])[::-1]  # from each joint to the tip of the stretched arm
    seen_by = "appears" if diagnosis.problem.is_pixels else "is"
    for joint, reach in enumerate(np.radians(beyond_mm).tolist()):
        yield Component(
            f"joint {joint + 1} {seen_by} off by, °",
            np.degrees(before.joints_rad[:, joint]),
            None if after is None else np.degrees(after.joints_rad[:, joint]),
            reach,
        )
    if not diagnosis.problem.is_pixels:
        return
    for axis, name in enumerate("xy"):
        common = None if after is None else _mean_seen(after.miss_mm[..., axis])
        yield Component(f"all markers off in {name}, mm", _mean_seen(before.miss_mm[..., axis]), common)
        for column, marker in enumerate(context.markers):
            title = f"marker {marker.upper()} off in {name}, mm"
            own = None if after is None else after.miss_mm[:, column, axis]
            yield Component(title, before.miss_mm[:, column, axis], own)


def _last_turn(moves: Array) -> Array:
    """(N,) which way the joint last turned, -1 or 1; NaN before it first does."""
    sides = np.where(np.abs(moves) > _STILL_RAD, np.sign(moves), 0.0)
    last = np.maximum.accumulate(np.where(sides != 0.0, np.arange(len(sides)), 0))
    return np.where(sides[last] != 0.0, sides[last], np.nan)


def _mean_seen(values: Array) -> Array:
    """(N,) mean over the columns of (N, M) that are seen."""
    seen = np.isfinite(values)
    mean = np.where(seen, values, 0.0).sum(axis=1) / np.maximum(seen.sum(axis=1), 1)
    return np.where(np.any(seen, axis=1), mean, np.nan)
