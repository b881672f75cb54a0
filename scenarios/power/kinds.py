"""The forms in which a fault may come, and how often each kind of them does: a rare kind is tried and weighs little.

Forms are of one kind where the same numbers are told of them and the same of these are zero: a load from the first
pose on is another thing than one that is hung there later, however large.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.random import Generator

from armtwin.models.catalogue.sealed import Hidden
from armtwin.models.catalogue.site import Site
from armtwin.sim.sealed import Scene, Wanted
from armtwin.sim.sealed.of_size import EVENT_PX, draw_at

# Draws that tell how often a kind comes; a kind that comes less often than this is left out.
_DRAWS = 60
_RARE = 0.08


def drawn_kinds(rng: Generator, scene: Scene, effect: str, site: Site, forms: int) -> list[tuple[Hidden, float]]:
    """Return about `forms` forms of an effect at a place, each kind at least once, with weights that sum to one."""
    drawn = [draw_at(rng, scene, Wanted(effect, EVENT_PX, site)) for _ in range(_DRAWS)]
    kinds: dict[tuple[tuple[str, bool], ...], list[Hidden]] = {}
    for hidden in drawn:
        kinds.setdefault(_kind(hidden), []).append(hidden)
    common = [kind for kind in kinds.values() if len(kind) >= _RARE * _DRAWS]
    chosen = [(kind[k], len(kind) / n) for kind in common for n in (_share_of(kind, common, forms),) for k in range(n)]
    total = sum(weight for _, weight in chosen)
    return [(hidden, weight / total) for hidden, weight in chosen]


def _share_of(kind: Sequence[Hidden], kinds: Sequence[Sequence[Hidden]], forms: int) -> int:
    return min(max(1, round(forms * len(kind) / sum(map(len, kinds)))), len(kind))


def _kind(hidden: Hidden) -> tuple[tuple[str, bool], ...]:
    said = hidden.parameters(hidden.start)
    return tuple(
        (name, not np.any(value)) if isinstance(value, int | float) else (name, False) for name, value in said.items()
    )
