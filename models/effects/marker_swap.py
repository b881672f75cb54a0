"""Two markers taken for each other in some frames: each is found where the other is expected.

Known forms: detectors that sort by size, colour or side and err where two markers come close or overlap, in single
frames or in runs. Covered: two markers exchanged in any frames. Set-up: an exchange in all rows is a matter of the
set-up (`calib/setup`). Not covered: three that go round, and one found twice.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import combinations
from typing import Any

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from armtwin.models.catalogue import sealed
from armtwin.models.catalogue.context import Context
from armtwin.models.catalogue.evidence import Sightings
from armtwin.models.catalogue.injection import other_marker, samples
from armtwin.models.catalogue.registry import Effect, Found, Site, Stage, View
from armtwin.models.errors import InputError
from armtwin.models.world import World, checked_marker, samples_of

Array = NDArray[np.float64]

# Both must miss their own place by this many standard deviations, and meet the other's within a part of that distance.
_MISSES = 10.0
_PART = 0.2


def find(context: Context, view: View) -> list[tuple[Site, Array]]:
    """Return for each pair of markers (named at the first) the other's index and the rows at which they are swapped."""
    found: list[tuple[Site, Array]] = []
    for first, second in combinations(range(len(context.markers)), 2):
        a, b = view.observed[:, first], view.observed[:, second]
        p, q = view.predicted[:, first], view.predicted[:, second]
        # Where one of the two was not seen, the other tells alone.
        own = np.fmin(view.misfit(a, p), view.misfit(b, q))
        crossed = np.fmax(view.misfit(a, q), view.misfit(b, p))
        rows = np.flatnonzero((own > _MISSES) & (crossed < _PART * own))
        if len(rows):
            found.append((Site(marker=context.markers[first]), np.array([second, *rows], dtype=float)))
    return found


def repair(context: Context, seen: Sightings, site: Site, values: Array) -> Sightings:
    """Give each of the two markers what was taken for the other; one of them may not have been seen."""
    assert site.marker is not None
    first, second, rows = context.markers.index(site.marker), int(values[0]), values[1:].astype(int)
    observed, counts = seen.observed.copy(), seen.counts.copy()
    observed[rows, first], observed[rows, second] = seen.observed[rows, second], seen.observed[rows, first]
    counts[rows, first], counts[rows, second] = seen.counts[rows, second], seen.counts[rows, first]
    return Sightings(observed, counts)


def _applies(context: Context, site: Site) -> str | None:
    return None if len(context.markers) > 1 else "a single marker is taken for no other"


def physical(context: Context, values: Array) -> dict[str, Any]:
    """Return the other marker's name and the swapped rows, as the simulated bench takes them."""
    return {"other": context.markers[int(values[0])], "samples": values[1:].astype(int).tolist()}


# --- how the simulated bench makes it ---


def inject(world: World, parameters: Mapping[str, Any], site: Site) -> World:
    """Let detection give `marker` the place of marker `other`, and the other way round, in the frames `samples`."""
    first, second = checked_marker(world, site.marker), checked_marker(world, str(parameters["other"]))
    if first == second:
        raise InputError(f"other: found {second!r}, which is the marker itself; another one is wanted")
    frames = samples_of(parameters)

    def swap(pixels: dict[str, NDArray[np.float64]], rng: Generator) -> dict[str, NDArray[np.float64]]:
        if first not in pixels or second not in pixels:  # nobody looks for one of them
            return pixels
        rows = [row for row in frames if row < len(pixels[first])]
        swapped = {name: points.copy() for name, points in pixels.items()}
        swapped[first][rows], swapped[second][rows] = pixels[second][rows], pixels[first][rows]
        return swapped

    return world.with_detection(swap)


def _hide(rng: Generator, s: sealed.Situation) -> sealed.Hidden:
    """Draw how it is hidden in a sealed world."""
    k = int(rng.integers(1, len(s.markers)))
    count = int(rng.integers(3, max(4, round(0.06 * s.n_poses)) + 1))
    samples = sorted(int(row) for row in rng.choice(s.n_poses, size=count, replace=False))
    return sealed.Hidden(lambda a: {"samples": samples, "other": s.markers[k]}, 1.0, 1.0, Site(marker=s.markers[k - 1]))


EFFECT = Effect(
    name="marker_swap",
    summary="two markers taken for each other in some frames",
    where="marker",
    stage=Stage.OBSERVATION,
    injector=inject,
    injected=(other_marker("other"), samples("samples")),
    confused_with=("outliers",),
    needs_camera=True,
    experiment="the frames in question looked at again",
    physical=physical,
    found=Found(find, repair),
    applies=_applies,
    sealed=sealed.Sealing(_hide, all_markers=True),
)
