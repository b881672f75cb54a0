"""The drives of a moving arm: how MuJoCo's numbers of a step make of a joint the servo that it is to be.

A motor on a voltage gives a torque that falls with its speed. So the loop is a spring to the command, limited to what
the motor gives at standstill, and a damper: it closes an error with the time constant damper / spring and turns no
faster than limit / damper. The spring is so stiff that the links' inertia and what hangs on them bend nothing; all
torques that are the drive's own (friction, rotor) are in proportion to it.

MuJoCo steps an undamped joint exactly and a damped one only to first order, and its constraints (dry friction, stops)
do not see a damper that is integrated implicitly. Therefore the damper is explicit, and its share of a step stands in
the armature, which makes it implicit to the constraints too. Spring, damper and armature of a step of h seconds are
those whose two poles are the poles of the continuous loop, exp(s h), so that an answer to a step of the command is
exact at every step.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from armtwin.models.motion_world import Drive

Array = NDArray[np.float64]

# Stiffness of a simulated loop, N m/rad: a link of 3e-3 kg m2 shifts its time constant by 3 microseconds.
STIFFNESS_NM_RAD = 50_000.0


class DriveBank:
    """The drives of an arm's n joints, as MuJoCo's numbers for a step of any length."""

    def __init__(self, drives: tuple[Drive, ...], nominal_stiffness_nm_rad: float) -> None:
        own = np.array([drive.time_constant_s for drive in drives])
        viscous = np.array([drive.viscous_s for drive in drives])
        self._time_s = own + viscous
        self._rotor_s2 = np.array([drive.armature_kg_m2 for drive in drives]) / nominal_stiffness_nm_rad
        # Viscous friction brakes the motor on its full voltage as well.
        self._speed = np.array([drive.speed_rad_s for drive in drives]) * own / self._time_s
        self._torque = np.array([np.inf if drive.torque_nm is None else drive.torque_nm for drive in drives])
        self._droop = np.array([drive.compliance_rad_per_nm for drive in drives])
        self._payload_droop = np.array([drive.payload_compliance_rad_per_nm for drive in drives])
        self._reserve = np.array([drive.reserve_rad for drive in drives])
        self._coulomb = np.array([drive.coulomb_rad for drive in drives])
        self._stribeck = np.array([drive.stribeck_rad for drive in drives])
        self._stribeck_speed = np.array([drive.stribeck_speed_rad_s for drive in drives])
        gives = np.where(self._droop > 0, self._droop, 1.0 / nominal_stiffness_nm_rad)
        self._load_share = np.array([drive.load_share for drive in drives]) * gives
        self._load_stribeck = np.array([drive.stribeck_load_share for drive in drives]) * gives
        self._drive_share = np.array([drive.drive_share for drive in drives])
        self._drive_stribeck = np.array([drive.stribeck_drive_share for drive in drives])

    @property
    def feels_load(self) -> bool:
        """Whether what hangs on the joints matters to any drive."""
        limited = bool(np.isfinite(self._torque).any())
        gives = bool(self._droop.any() or self._payload_droop.any())
        return limited or gives or bool(self._load_share.any() or self._load_stribeck.any())

    @property
    def feels_motion(self) -> bool:
        """Whether a drive's numbers follow its speed or its torque: some friction, and what a heavy rotor may take."""
        of_speed = bool(self._stribeck.any() or self._rotor_s2.any())
        return of_speed or bool(self._drive_share.any() or self._drive_stribeck.any())

    @property
    def has_friction(self) -> bool:
        """Whether any joint has dry friction."""
        of_load = bool(self._load_share.any() or self._load_stribeck.any())
        of_drive = bool(self._drive_share.any() or self._drive_stribeck.any())
        return bool(self._coulomb.any() or self._stribeck.any()) or of_load or of_drive

    def step(self, h: float) -> tuple[Array, Array]:
        """(n,) damping, N m s/rad, and armature, kg m2, for a step of `h` seconds."""
        with np.errstate(divide="ignore", over="ignore"):
            decay = np.where(self._rotor_s2 > 0, self._time_s / np.maximum(self._rotor_s2, 1e-300), np.inf)
        product = np.exp(-decay * h)  # of the poles
        # s^2 rotor + s time + 1 = 0, stably for a rotor of nothing
        root = np.sqrt((self._time_s**2 - 4.0 * self._rotor_s2).astype(complex))
        slow = -2.0 / (self._time_s + root)
        one = np.exp(slow * h)
        other = np.where(self._rotor_s2 > 0, np.conj(one), 0.0)
        real = root.imag == 0
        other = np.where(real, product / one, other)
        whole = STIFFNESS_NM_RAD / (1.0 + product - (one + other)).real
        return h * (1.0 - product) * whole, h * h * whole

    def push_limits(self, damping: Array, load: Array, friction: Array, rotor: Array | None = None) -> Array:
        """(n, 2) least and most torque of the springs, N m, under loads (n,), N m, that gravity puts on the joints.

        `load` is the torque that would hold the joint. Of the speed that is left under a load as much is lost as the
        load's share of the stall torque; a load that helps makes nothing faster. What limits the speed is the drive's
        electronics: against dry `friction` (n,), N m, the motor has as much in reserve, and `rotor` (n, 2), N m, to
        bring its rotor down or up to that speed.
        """
        share = load / self._torque
        up = np.clip(1.0 - share, 0.0, 1.0)
        down = np.clip(1.0 + share, 0.0, 1.0)
        force = damping * self._speed
        rubs = friction + STIFFNESS_NM_RAD * self._reserve
        limits = np.stack([-force * down - rubs, force * up + rubs], axis=-1)
        return limits if rotor is None else limits + rotor

    def rotor_reserve(self, armature: Array, damping: Array, speed: Array, h: float) -> Array:
        """(n, 2) torque, N m, that brings the rotors from speeds (n,), rad/s, down and up to the limit in a step."""
        inertia = np.maximum(armature / h - damping, 0.0)  # beyond the damper's own share of the armature
        return np.stack(
            [inertia * np.minimum(-self._speed - speed, 0.0), inertia * np.maximum(self._speed - speed, 0.0)], -1
        )

    def droop(self, load: Array, payload: Array) -> Array:
        """(n,) rad by which the loops give under the drawn loads and the undeclared payload's, N m."""
        return self._droop * (load + payload) + self._payload_droop * payload

    def friction(self, load: Array, speed: Array, driven: Array) -> Array:
        """(n,) torque of dry friction, N m, at loads (n,), N m, speeds (n,), rad/s, and torques of the drives, N m."""
        gear = np.abs(driven) / STIFFNESS_NM_RAD
        sliding = self._coulomb + self._load_share * np.abs(load) + self._drive_share * gear
        sticking = self._stribeck + self._load_stribeck * np.abs(load) + self._drive_stribeck * gear
        return STIFFNESS_NM_RAD * (sliding + sticking * np.exp(-((speed / self._stribeck_speed) ** 2)))
