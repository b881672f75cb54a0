"""Gross detection errors: single markers found far from where they are, in single frames.

Known forms: reflections, edges of the background, motion blur, a digit misread in a written table; few and far.
Covered: any number of single points that are far off while their surroundings are calm. Left out without a name: the
tail of noise that is no bell (exponential ones go on to eight standard deviations in a thousand points). Not covered:
errors in runs, as of a lamp that was switched on.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from armtwin.models.catalogue import sealed
from armtwin.models.catalogue.context import Context
from armtwin.models.catalogue.evidence import Sightings
from armtwin.models.catalogue.found import Measured
from armtwin.models.catalogue.injection import Injected
from armtwin.models.catalogue.motion_effect import MotionEffect
from armtwin.models.catalogue.registry import Effect, Found, Site, Stage, View
from armtwin.models.motion_world import MotionWorld
from armtwin.models.world import World

Array = NDArray[np.float64]

# Of Gaussian noise one point in four millions lies farther out; a gross error is also alone in its frame or in time.
_GROSS = 5.5
_CALM = 3.5
# One or two points that are no farther out than this may be the tail of errors that are no bell: Student's with eight
# degrees of freedom has one in five thousand of its points beyond 5.5.
_FEW = 3
_GROSS_OF_FEW = 7.5
# Errors with tails are no gross ones: one of them must lie farther out than the tail goes on to in one recording of a
# hundred, taken to fall off exponentially (Laplace's) as fast as from the median to nine tenths.
_TAIL_FROM = 0.9
_IN_ONE_RECORDING = 0.01
# So little is a command's border of a threshold or a lattice off, rad, by what a model knows of it.
_HAIR_RAD = (3e-4, 2e-3)
# Less than a tenth of a pixel is no gross error however quiet the camera: a rim's shading or a codec's block does that.
_GROSS_PX = 0.1
# Two detections do not fail by the same vector to within this part of its length.
_ALIKE = 0.6
# A lever that turns in the arm's plane changes its length in the picture by so much of the way, seen somewhat askew.
_KEYSTONE = 0.01


def find(context: Context, view: View) -> list[tuple[Site, Array]]:
    """Return (row, marker) pairs, flattened, of points that are far off while their surroundings are calm."""
    misfit = view.misfit(view.observed, view.predicted)
    residual = view.observed - view.predicted
    far = misfit > _GROSS
    if view.observed.shape[-1] == 2:
        far &= np.linalg.norm(residual, axis=-1) > _GROSS_PX
    rows = [
        (row, column)
        for row, column in np.argwhere(far).tolist()
        if _calm_in_time(misfit, row, column)
        and _alone_in_frame(misfit, residual, row, column)
        and not _turned(context, view, row, column)
    ]
    if len(rows) < _FEW:
        rows = [at for at in rows if misfit[at] > _GROSS_OF_FEW]
    return [(Site(), np.array(rows, dtype=float).ravel())] if rows else []


def certain(context: Context, view: View, site: Site, values: Array) -> bool:
    """Whether one of them lies beyond any tail of the noise; the first pose alone may tell how the bench was found.

    Nor are those that a hair's breadth in a command makes up for: there a threshold or a lattice has its border.
    """
    misfit = view.misfit(view.observed, view.predicted)
    at = values.reshape(-1, 2).astype(int)
    at = at[[not _at_a_border(context, view, row, column) for row, column in at.tolist()]]
    if not len(at):
        return False
    farthest = float(np.nanmax(misfit[at[:, 0], at[:, 1]]))
    return bool(at[:, 0].any()) and farthest > _end_of_tail(misfit)


def _at_a_border(context: Context, view: View, row: int, column: int) -> bool:
    """Whether another command, next to the one that was sent, leads to what was seen."""
    if view.replay is None:
        return False
    for joint in range(context.q_cmd.shape[1]):
        for step in (*_HAIR_RAD, *(-hair for hair in _HAIR_RAD)):
            commands = context.q_cmd.copy()
            commands[row, joint] += step
            if view.misfit(view.observed[row], view.replay(commands)[row])[column] < _CALM:
                return True
    return False


def _end_of_tail(misfit: Array) -> float:
    """Return how far out the farthest of so many points lies where errors fall off exponentially."""
    seen = misfit[np.isfinite(misfit)]
    if not len(seen):
        return 0.0
    middle, high = np.quantile(seen, (0.5, _TAIL_FROM))
    falls_off = (high - middle) / np.log(0.5 / (1.0 - _TAIL_FROM))
    return float(high + falls_off * np.log((1.0 - _TAIL_FROM) * len(seen) / _IN_ONE_RECORDING))


def _calm_in_time(misfit: Array, row: int, column: int) -> bool:
    """Whether the same marker is where it should be in half of the frames just before and after."""
    around = misfit[max(0, row - 2) : row + 3, column].copy()
    around[min(row, 2)] = np.nan
    around = around[np.isfinite(around)]
    return bool((around < _CALM).sum() >= 0.5 * len(around))


def _alone_in_frame(misfit: Array, residual: Array, row: int, column: int) -> bool:
    """Whether at most one other marker in the frame is off, and not by much the same: the arm takes several along."""
    others = np.delete(np.arange(misfit.shape[1]), column)
    off = others[np.nan_to_num(misfit[row, others]) > _CALM]
    if len(off) > 1:
        return False
    alike = np.linalg.norm(residual[row, off] - residual[row, column], axis=-1)
    return not bool((alike < _ALIKE * np.linalg.norm(residual[row, column])).any())


def _turned(context: Context, view: View, row: int, column: int) -> bool:
    """Whether the turn of one joint would move this marker so, and no other that was seen: a step of the servo."""
    if view.observed.shape[-1] != 2:
        return False
    place = {name: k for k, name in enumerate(context.markers)}
    chain = context.arm.marker_names
    own = context.markers[column]
    index = chain.index(own) if own in chain else len(chain) - 1
    seen = np.isfinite(view.observed[row]).all(axis=-1)
    residual = view.observed[row, column] - view.predicted[row, column]
    for hinge in range(index - 1, -1, -1):  # joint hinge + 1 turns about marker chain[hinge]
        moved = [place[name] for name in chain[hinge + 1 :] if name in place and name != own]
        if any(seen[k] for k in moved):
            return False  # so would this have moved, and of those beyond it
        if chain[hinge] in place:
            lever = view.predicted[row, column] - view.predicted[row, place[chain[hinge]]]
            longer = float(np.linalg.norm(lever + residual) - np.linalg.norm(lever))
            if abs(longer) < _CALM * view.scale + _KEYSTONE * float(np.linalg.norm(residual)):
                return True
    return False


def repair(context: Context, seen: Sightings, site: Site, values: Array) -> Sightings:
    """Leave them out."""
    counts = seen.counts.copy()
    rows, columns = values.reshape(-1, 2).astype(int).T
    counts[rows, columns] = False
    return Sightings(seen.observed, counts)


def measure(missed: Array, n_counted: int) -> dict[str, Measured]:
    """Return their share of the sightings, and their mean distance."""
    far = np.linalg.norm(missed, axis=-1)
    seen = n_counted + len(far)
    rate = len(far) / seen
    spread = float(far.std(ddof=1) / np.sqrt(len(far))) if len(far) > 1 else float("nan")
    size = "size_px" if missed.shape[-1] == 2 else "size_rad"
    return {"rate": (rate, float(np.sqrt(rate * (1.0 - rate) / seen))), size: (float(far.mean()), spread)}


# --- how the simulated bench makes it ---


def inject(world: World, parameters: Mapping[str, Any], site: Site) -> World:
    """Let detection lock on something else in a share `rate` of the sightings, about `size_px` away.

    Reflections and edges lie in any direction, between half and one and a half times that far.
    """
    rate, size = float(parameters["rate"]), float(parameters["size_px"])

    def mistake(pixels: dict[str, NDArray[np.float64]], rng: Generator) -> dict[str, NDArray[np.float64]]:
        mistaken = {}
        for name, points in pixels.items():
            wrong = rng.random(len(points)) < rate
            direction = rng.uniform(-np.pi, np.pi, len(points))
            distance = size * rng.uniform(0.5, 1.5, len(points)) * wrong
            mistaken[name] = points + distance[:, None] * np.stack([np.cos(direction), np.sin(direction)], axis=-1)
        return mistaken

    return world.with_detection(mistake)


def _hide(rng: Generator, s: sealed.Situation) -> sealed.Hidden:
    """Draw how it is hidden in a sealed world."""
    rate = float(rng.uniform(0.01, 0.05))
    return sealed.Hidden(lambda a: {"rate": rate, "size_px": a}, 10.0, 80.0)


EFFECT = Effect(
    name="outliers",
    summary="gross detection errors",
    where="arm",
    stage=Stage.OBSERVATION,
    injector=inject,
    injected=(Injected("rate", (0.0, 1.0)), Injected("size_px", (0.0, 5000.0))),
    confused_with=("marker_swap", "missed_command"),
    experiment="the frames in question looked at again",
    found=Found(find, repair, measure, last=True, certain=certain),
    sealed=sealed.Sealing(_hide),
)


def inject_in_motion(world: MotionWorld, parameters: Mapping[str, Any], site: Site) -> MotionWorld:
    """Let a share `rate` of the readings of `joint` be garbled on the bus, by half to one and a half `size_rad`."""
    (index,) = world.joints_at(site)
    rate, size = float(parameters["rate"]), float(parameters["size_rad"])

    def garble(time_s: Array, q: Array, rng: Generator) -> Array:
        wrong = rng.random(len(q)) < rate
        off = size * rng.uniform(0.5, 1.5, len(q)) * np.where(rng.random(len(q)) < 0.5, -1.0, 1.0)
        out = q.copy()
        out[:, index] += np.where(wrong, off, 0.0)
        return out

    return world.with_reading(garble)


IN_MOTION = MotionEffect(
    name=EFFECT.name,
    summary=EFFECT.summary,
    where="joint",
    confused_with=("missed_command", "sampling"),
    experiment="the readings in question taken again",
    motions=("holds",),
    injector=inject_in_motion,
    injected=(Injected("rate", (0.0, 1.0)), Injected("size_rad", (0.0, 3.2))),
)
