"""The world of a moving arm: what is physically true of its drives, its wires and its readings, and not declared.

An effect's injector takes such a world and returns one with a fault where it arises:

    commands --wires--> drives --mechanics, events--> arm --readings--> recording

Nothing here is a formula of the estimator: a delay is a delay line, play a hinge with a gap, friction MuJoCo's. All
of a drive's torques are stated as angles, over the stiffness of its loop, or for the nominal stiffness of
`models/nominal/servo.toml` where they are torques: whoever simulates them chooses a stiffness of his own.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from armtwin.models.catalogue.site import Site
from armtwin.models.errors import InputError
from armtwin.models.motion_arm import MotionArm
from armtwin.models.servo import Servo, nominal_servo

if TYPE_CHECKING:
    import mujoco

Array = NDArray[np.float64]


# As hard as MuJoCo lets a constraint be: it answers within two steps, whatever their length.
HARD_SOLREF = [1e-5, 1.0]
HARD_SOLIMP = [0.9999, 0.9999, 0.001, 0.5, 2.0]


@dataclass(frozen=True, eq=False)
class Motion:
    """One motion: rows at `time_s` (N,), s, each with the command (N, n), rad, that is in force from then on."""

    name: str
    time_s: Array
    q_cmd: Array


@dataclass(frozen=True, eq=False)
class Wire:
    """What arrives at one drive: commands `q` (M,), rad, at `time_s` (M,), in order, and the rows that sent them."""

    time_s: Array
    q: Array
    row: NDArray[np.int64]


# What the wires make of the commands on their way, all joints' at once.
Wiring = Callable[[Sequence[Wire]], list[Wire]]
# Edits the model before it is compiled; `scale` is the simulated loop's stiffness, N m/rad.
Mechanism = Callable[["mujoco.MjSpec", float], None]


class Reading(Protocol):
    """What becomes of the readings on their way."""

    def __call__(self, time_s: Array, q: Array, rng: Generator, /) -> Array:
        """Return the readings (N, n), rad, taken at `time_s` (N,), as they are recorded."""


class Disturbance(Protocol):
    """Something that pushes at the drives."""

    def __call__(self, time_s: float, q: Array, speed: Array, target: Array, /) -> Array:
        """Return by how much the loops are led astray, (n,) rad."""


@dataclass(frozen=True)
class Slip:
    """Link `joint` (index from 0) turns on its horn by `jump_rad` at `time_s`."""

    joint: int
    time_s: float
    jump_rad: float


@dataclass(frozen=True)
class Drive:
    """One joint's servo in time.

    Attributes:
        time_constant_s: of its loop.
        speed_rad_s: no faster than this.
        torque_nm: stall torque of its motor, or None for more than any load.
        compliance_rad_per_nm: what its loop gives under a load, for want of an integral part.
        payload_compliance_rad_per_nm: the same under a mass that is not drawn.
        coulomb_rad, stribeck_rad: dry friction, and what is added to it at standstill, over the loop's stiffness.
        stribeck_speed_rad_s: at which 1/e of the addition is left.
        load_share, drive_share: dry friction for each unit of torque of the load, and of what the drive gives.
        stribeck_load_share, stribeck_drive_share: the same, of what is added at standstill.
        viscous_s: viscous friction over the loop's stiffness.
        armature_kg_m2: inertia of its rotor, seen through the gear.
        reserve_rad: of what rubs in the mechanics, over the stiffness: what the motor has left for it at full speed.

    """

    time_constant_s: float
    speed_rad_s: float
    torque_nm: float | None = None
    compliance_rad_per_nm: float = 0.0
    payload_compliance_rad_per_nm: float = 0.0
    coulomb_rad: float = 0.0
    stribeck_rad: float = 0.0
    stribeck_speed_rad_s: float = 0.1
    load_share: float = 0.0
    drive_share: float = 0.0
    stribeck_load_share: float = 0.0
    stribeck_drive_share: float = 0.0
    viscous_s: float = 0.0
    armature_kg_m2: float = 0.0
    reserve_rad: float = 0.0


@dataclass(frozen=True, eq=False)
class MotionWorld:
    """An arm, its drives, and what is wrong with them.

    Attributes:
        arm: as it is drawn.
        servo: the servo that the twin has at every joint.
        drives: (n,) as they are.
        zeros_rad: (n,) what a joint reads where the model's angle is zero.
        payload_kg, payload_from_s: mass at the tip that nobody declared, and since when.
        wiring, mechanics, slips, disturbances, readings: what else is wrong, in the order in which it was added.

    """

    arm: MotionArm
    servo: Servo
    drives: tuple[Drive, ...]
    zeros_rad: Array
    payload_kg: float = 0.0
    payload_from_s: float = -np.inf
    wiring: tuple[Wiring, ...] = ()
    mechanics: tuple[Mechanism, ...] = ()
    slips: tuple[Slip, ...] = ()
    disturbances: tuple[Callable[[], Disturbance], ...] = ()
    readings: tuple[Reading, ...] = ()
    series_hinges: Mapping[int, tuple[str, ...]] = field(default_factory=dict)

    def with_drive(self, index: int, **changes: float) -> MotionWorld:
        """Return the world with the drive of a joint (index from 0) changed."""
        drives = list(self.drives)
        drives[index] = replace(drives[index], **changes)
        return replace(self, drives=tuple(drives))

    def with_wiring(self, stage: Wiring) -> MotionWorld:
        """Return the world with one more stage between the commands and the drives."""
        return replace(self, wiring=(*self.wiring, stage))

    def with_values(self, index: int, of: Callable[[Array], Array]) -> MotionWorld:
        """Return the world in which the drive of a joint hears other angles than it was sent."""

        def stage(wires: Sequence[Wire]) -> list[Wire]:
            out = list(wires)
            out[index] = replace(out[index], q=of(out[index].q))
            return out

        return self.with_wiring(stage)

    def with_mechanism(self, mechanism: Mechanism) -> MotionWorld:
        """Return the world with one more edit of the arm's model."""
        return replace(self, mechanics=(*self.mechanics, mechanism))

    def with_series_hinge(self, index: int, name: str) -> MotionWorld:
        """Return the world in which the encoder of a joint sits behind one more hinge, which a mechanism adds."""
        hinges = {**self.series_hinges, index: (*self.series_hinges.get(index, ()), name)}
        return replace(self, series_hinges=hinges)

    def with_slip(self, slip: Slip) -> MotionWorld:
        """Return the world with one more slip of a horn."""
        return replace(self, slips=(*self.slips, slip))

    def with_disturbance(self, factory: Callable[[], Disturbance]) -> MotionWorld:
        """Return the world with one more thing that pushes at the drives; a fresh one is made for every run."""
        return replace(self, disturbances=(*self.disturbances, factory))

    def with_reading(self, stage: Reading) -> MotionWorld:
        """Return the world with one more stage between the encoders and the recording."""
        return replace(self, readings=(*self.readings, stage))

    def joints_at(self, site: Site) -> list[int]:
        """Indices from 0 of the joints of a site: its joint's, or of a site that names none all; `InputError`."""
        if site.joint is None:
            return list(range(self.arm.n_joints))
        if not 1 <= site.joint <= self.arm.n_joints:
            raise InputError(f"joint {site.joint}: this arm has joints 1 to {self.arm.n_joints}")
        return [site.joint - 1]


def ideal_motion_world(arm: MotionArm, zeros_rad: Array | None = None) -> MotionWorld:
    """Return the world in which every drive is the nominal servo."""
    servo = nominal_servo()
    zeros = np.zeros(arm.n_joints) if zeros_rad is None else np.asarray(zeros_rad, dtype=float)
    drive = Drive(servo.loop_time_s, servo.no_load_speed_rad_s)
    return MotionWorld(arm, servo, (drive,) * arm.n_joints, zeros)


def positive(parameters: Mapping[str, Any], name: str) -> float:
    """Return a parameter that has to be a number above zero; raises `InputError`."""
    value = float(parameters[name])
    if not value > 0.0 or not np.isfinite(value):
        raise InputError(f"{name}: found {value:g}, a number above 0 is wanted")
    return value
