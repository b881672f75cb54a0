"""Forms of planar arms: what the lengths alone do not say, as data. The one place that turns an arm's name into it.

A file may call its arm by any name; a name that stands in `_FORMS` brings its form along, every other name is a chain
of straight links that lie along x at zero.
"""

from __future__ import annotations

import string
from dataclasses import dataclass

import numpy as np

MOST_JOINTS = 6


@dataclass(frozen=True)
class Form:
    """How the links of an arm sit on one another and what is stuck on them.

    Attributes:
        zero_turn_rad: angle of each link against its predecessor (the first: against x) at q = 0.
        zero_is_drawn: whether a drawing states that zero pose; otherwise it is wherever the user's zero is.
        tip_turn_rad: orientation of the tip at q = 0.
        tip_offset: whether one more length than joints stands at the end, square to the last link (clockwise).
        markers: letters of the markers on the axes and the tip, base first; None for a, b, c, ...
        corner: letter of the marker at the corner between the last link and the tip offset, if one may be there.
        numbers: how lengths are numbered where people read them; None for 1, 2, 3, ...
        n_joints: how many joints an arm of this name has; None for any.

    """

    zero_turn_rad: float = 0.0
    zero_is_drawn: bool = False
    tip_turn_rad: float = 0.0
    tip_offset: bool = False
    markers: tuple[str, ...] | None = None
    corner: str | None = None
    numbers: tuple[int, ...] | None = None
    n_joints: int | None = None

    def joints_of(self, n_lengths: int) -> int:
        """Return the number of joints of an arm with so many lengths."""
        return n_lengths - self.tip_offset

    def marker_names(self, n_joints: int) -> tuple[str, ...]:
        """(n + 1) letters of the markers on the axes and the tip."""
        return tuple(string.ascii_lowercase[: n_joints + 1]) if self.markers is None else self.markers

    def length_numbers(self, n_lengths: int) -> tuple[int, ...]:
        """Return the numbers of so many lengths."""
        return tuple(range(1, n_lengths + 1)) if self.numbers is None else self.numbers


STRAIGHT = Form()

# Table 1 and Figure 1 of the paper: every link a quarter turn against the one before, the last one bent (l4, then l5
# square to it), so that C, the corner E and F are one rigid body.
_PAPER = Form(
    zero_turn_rad=np.pi / 2,
    zero_is_drawn=True,
    tip_turn_rad=np.pi,
    tip_offset=True,
    markers=("a", "b", "c", "f"),
    corner="e",
    numbers=(1, 2, 4, 5),
    n_joints=3,
)

_FORMS = {"planar3": _PAPER}


def form_named(name: str) -> Form:
    """Return the form that an arm's name stands for; a straight chain for a name that is the user's own."""
    return _FORMS.get(name, STRAIGHT)
