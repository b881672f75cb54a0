"""Effects of single samples: found in what a model leaves, where others are fitted."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from armtwin.models.catalogue.context import Context
from armtwin.models.catalogue.evidence import Sightings, View
from armtwin.models.catalogue.site import Site

Array = NDArray[np.float64]
# A value with its standard deviation.
Measured = tuple[float, float]


class Find(Protocol):
    """Finds single samples: sites with the values (k,) of what was found there."""

    def __call__(self, context: Context, view: View, /) -> list[tuple[Site, Array]]:
        """Return what a view of the residuals shows; an empty list where it shows nothing of the kind."""


class Repair(Protocol):
    """Puts the sightings right that were found, or leaves them out."""

    def __call__(self, context: Context, seen: Sightings, site: Site, values: Array, /) -> Sightings:
        """Return repaired copies; `seen` itself stays as it is."""


@dataclass(frozen=True)
class Found:
    """How an effect of single samples is found, and what becomes of them.

    Attributes:
        find: looks for it in what a model leaves.
        repair: puts the observations right; None for an effect whose term explains the samples instead.
        measure: what is told of it and what its injector takes, by name, from the observations' departures (k, d) at
            the samples that were found and the number of sightings that count; None: their number alone.
        last: it takes whatever is far off, so that every other effect is looked for before it.
        certain: whether what was found and put right is worth a name, by what the final model leaves; None: always.

    """

    find: Find
    repair: Repair | None = None
    measure: Callable[[Array, int], Mapping[str, Measured]] | None = None
    last: bool = False
    certain: Callable[[Context, View, Site, Array], bool] | None = None
