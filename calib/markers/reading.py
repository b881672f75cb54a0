"""What one picture says of an arm's markers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from armtwin.calib.markers.disc import Array, Disc

Status = Literal["seen", "hidden", "ambiguous"]


@dataclass(frozen=True, eq=False)
class MarkerReading:
    """Markers by name.

    Attributes:
        discs: the disc of each marker that was seen, by name.
        status: seen, hidden (no disc where it can be), or ambiguous (two explanations fit alike, or one that
            contradicts the command); a marker that is not seen has no pixels.
        messages: one line for each marker that is not wholly seen, with the reason.

    """

    discs: dict[str, Disc]
    status: dict[str, Status]
    messages: tuple[str, ...]

    @property
    def pixels(self) -> dict[str, Array]:
        """(2,) raw pixels of each marker's centre, NaN where it is not seen."""
        return {name: self.discs[name].centre if name in self.discs else np.full(2, np.nan) for name in self.status}

    @property
    def covariances(self) -> dict[str, Array]:
        """(2, 2) px^2 of each marker's centre, NaN where it is not seen or the detector gives none."""
        return {
            name: self.discs[name].covariance if name in self.discs else np.full((2, 2), np.nan) for name in self.status
        }

    @property
    def is_complete(self) -> bool:
        """Whether every marker was seen."""
        return len(self.discs) == len(self.status)
