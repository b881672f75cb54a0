"""The arm as drawn: link lengths, zero pose, masses and the direction of gravity."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from armtwin.models.arm_form import STRAIGHT, Form, form_named
from armtwin.models.toml_reader import read_toml
from armtwin.models.validation import ArmFile, ArmTable, check

Array = NDArray[np.float64]

NOMINAL = Path(__file__).parent / "nominal"


@dataclass(frozen=True, eq=False)
class Arm:
    """A serial arm of n planar joints.

    Attributes:
        name: what its file calls it.
        link_lengths_mm: (n,) mm, base first; with a tip offset (n + 1,), the offset last.
        gravity_m_s2: (2,) in the robot frame; zero for an arm that lies flat.
        link_masses_kg: (n,) or None where not known.
        tip_mass_kg: mass at the tip, or None where not known.
        form: zero pose, tip offset and markers.
        joints: names of the joints, base first, or None where they are only counted.
        joint_limits_rad: (n, 2) smallest and largest angle of each joint, or None where the drawing states none.

    """

    name: str
    link_lengths_mm: Array
    gravity_m_s2: Array
    link_masses_kg: Array | None = None
    tip_mass_kg: float | None = None
    form: Form = STRAIGHT
    joints: tuple[str, ...] | None = None
    joint_limits_rad: Array | None = None

    @property
    def joint_labels(self) -> tuple[str, ...]:
        """The joints for people: joint 1, or joint 1 (shoulder) where it has a name."""
        names = self.joints or ("",) * self.n_joints
        return tuple(f"joint {i}" + (f" ({name})" if name else "") for i, name in enumerate(names, start=1))

    @property
    def has_tip_offset(self) -> bool:
        """Whether the last length stands square to the last link, at its end."""
        return self.form.tip_offset

    @property
    def n_joints(self) -> int:
        """Number of joints."""
        return self.form.joints_of(len(self.link_lengths_mm))

    @property
    def zero_pose_rad(self) -> Array:
        """(n,) angle of each link against its predecessor at q = 0."""
        return np.full(self.n_joints, self.form.zero_turn_rad)

    @property
    def length_numbers(self) -> tuple[int, ...]:
        """The numbers by which people know the lengths."""
        return self.form.length_numbers(len(self.link_lengths_mm))

    @property
    def link_names(self) -> tuple[str, ...]:
        """The n links by their lengths: l1, l2, ...; one with a tip offset bears both numbers (l45)."""
        names = [str(number) for number in self.length_numbers]
        if self.has_tip_offset:
            names[-2:] = ["".join(names[-2:])]
        return tuple(f"l{name}" for name in names)

    @property
    def marker_names(self) -> tuple[str, ...]:
        """The (n + 1) markers on the axes and the tip, base first."""
        return self.form.marker_names(self.n_joints)

    @property
    def known_markers(self) -> tuple[str, ...]:
        """Every marker that a recording may hold: on the axes, the tip, and maybe the last link's corner."""
        corner = () if self.form.corner is None else (self.form.corner,)
        return tuple(sorted((*self.marker_names, *corner)))

    def is_corner(self, marker: str) -> bool:
        """Whether `marker` sits where the tip offset begins instead of at the end of its link."""
        return marker == self.form.corner

    def links_to(self, marker: str) -> int:
        """Return on how many links the place of `marker` depends: 0 on the base, n at the tip and at its corner."""
        return self.n_joints if self.is_corner(marker) else self.marker_names.index(marker)


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
        form=form_named(arm.name),
        joints=None if arm.joints is None else tuple(arm.joints),
        joint_limits_rad=None if arm.joint_limits_rad is None else np.array(arm.joint_limits_rad),
    )
