"""The arm as drawn: link lengths, zero pose, masses and the direction of gravity."""

from __future__ import annotations

import string
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from armtwin.models.toml_reader import read_toml
from armtwin.models.validation import ArmFile, ArmTable, check

Array = NDArray[np.float64]

NOMINAL = Path(__file__).parent / "nominal"

# Markers of the paper's Figure 1; E is the corner between l4 and l5, on the same rigid body as C and F.
_PLANAR3_MARKERS = ("a", "b", "c", "e", "f")


@dataclass(frozen=True, eq=False)
class Arm:
    """A serial arm of n planar joints.

    Attributes:
        name: "planar3" for the paper's arm; any other name is a plain chain.
        link_lengths_mm: (n,) mm; planar3 has a fourth entry, its l5, square to l4 at the tip.
        gravity_m_s2: (2,) in the robot frame; zero for an arm that lies flat.
        link_masses_kg: (n,) or None where not known.
        tip_mass_kg: mass at the tip, or None where not known.

    """

    name: str
    link_lengths_mm: Array
    gravity_m_s2: Array
    link_masses_kg: Array | None = None
    tip_mass_kg: float | None = None

    @property
    def is_planar3(self) -> bool:
        """Whether this is the paper's arm, with the bent last link l4, l5."""
        return self.name == "planar3"

    @property
    def n_joints(self) -> int:
        """Number of joints."""
        return len(self.link_lengths_mm) - (1 if self.is_planar3 else 0)

    @property
    def zero_pose_rad(self) -> Array:
        """(n,) angle of each link against its predecessor at q = 0: a quarter turn each for planar3 (Table 1)."""
        return np.full(self.n_joints, np.pi / 2 if self.is_planar3 else 0.0)

    @property
    def marker_names(self) -> tuple[str, ...]:
        """The markers on the axes and the tip, base first: a, b, c, f for planar3; one letter an axis otherwise."""
        return ("a", "b", "c", "f") if self.is_planar3 else tuple(string.ascii_lowercase[: self.n_joints + 1])

    @property
    def known_markers(self) -> tuple[str, ...]:
        """Every marker that a recording of this arm may hold; planar3 may also show E, the corner of its last link."""
        return _PLANAR3_MARKERS if self.is_planar3 else self.marker_names


def nominal_arm() -> Arm:
    """Return the paper's arm (Table 1)."""
    return read_arm(NOMINAL / "arm.toml")


def read_arm(path: Path) -> Arm:
    """Read an arm file (TOML, `armtwin.arm/1`), or the drawing in a twin's file; raises `InputError`."""
    table = read_toml(path)
    if str(table.get("schema")).startswith("armtwin.twin/"):
        table = {"schema": "armtwin.arm/1", **_table(table.get("arm"))}
    return arm_from_table(check(ArmFile, table, path.name))


def _table(value: object) -> dict[str, object]:
    return value if isinstance(value, dict) else {}


def arm_from_table(arm: ArmTable) -> Arm:
    """Return the arm that a validated arm table describes."""
    return Arm(
        name=arm.name,
        link_lengths_mm=np.array(arm.link_lengths_mm),
        gravity_m_s2=np.array(arm.gravity_m_s2),
        link_masses_kg=None if arm.link_masses_kg is None else np.array(arm.link_masses_kg),
        tip_mass_kg=arm.tip_mass_kg,
    )
