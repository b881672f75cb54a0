"""What was found at one joint: the forms in the order of the search, and the loop's values that they were fitted to."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.motion.candidates import Form
from armtwin.calib.motion.fit import NEARLY_NOMINAL, ZERO, Fit
from armtwin.calib.motion.series import Series, white_noise
from armtwin.models.catalogue.motion_effect import Slot

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class JointModel:
    """What was found at a joint (from 0).

    Attributes:
        joint: its index.
        forms: what was added, in the order of the search.
        fit: the loop's values and their remainder.
        geometric: the same with the zero alone.
        noise_rad: deviation of what has no memory.
        equivalents: for forms that another explains as well, that other's effect.

    """

    joint: int
    forms: tuple[Form, ...]
    fit: Fit
    geometric: Fit
    noise_rad: float
    equivalents: tuple[tuple[str, str], ...] = ()

    @property
    def slots(self) -> tuple[Slot, ...]:
        """All slots that are fitted."""
        return fitted_slots(self.forms)

    @property
    def effects(self) -> tuple[str, ...]:
        """Names of the effects, each once, in the order found."""
        return tuple(dict.fromkeys(form.effect for form in self.forms))


def fitted_slots(forms: Sequence[Form]) -> tuple[Slot, ...]:
    """Return the slots of forms, after those that are fitted always."""
    own = tuple(slot for form in forms for slot in form.slots)
    nearly = () if any(slot.slot == NEARLY_NOMINAL.slot for slot in own) else (NEARLY_NOMINAL,)
    return (ZERO, *nearly, *own)


def noise_of(series: Series, e: Array) -> float:
    """Return the deviation of a remainder's part without memory, rad."""
    return white_noise(e[series.used], series.first[series.used], series.grain_rad)
