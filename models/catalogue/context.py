"""What a model term may know: commands, their order and times, arm and camera as assumed; nothing that was measured."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from armtwin.models.arm import Arm
from armtwin.models.camera import Camera
from armtwin.models.commands import CommandSeries, moving_commands, settled_commands
from armtwin.models.kinematics import complex_links

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

# Moves below this are no moves: a command repeated.
STILL_RAD = 1e-6
# Where a recording names no masses: a printed link with its hobby servo weighs about this much.
TYPICAL_LINK_MASS_KG = 0.045
TYPICAL_TIP_MASS_KG = 0.02


@dataclass(frozen=True, eq=False)
class Context:
    """The known side of a recording.

    Attributes:
        arm, camera, plane_z_mm: as assumed.
        markers: names of the markers that are seen, base first.
        q_cmd: (N, n) commands, rad, in the order they happened.
        time_s: (N,) when each row was seen, s, or None where time was not recorded.
        trajectory: (N,) names.
        payload_kg: (N,) declared mass at the tip.
        temperature_c: (N,) or None.
        links: (n,) complex link lengths of the calibrated arm, mm; the drawing's until it is calibrated.
        commanded_s: (N,) when each command was given, NaN where that is not known, or None.
        moving: whether the rows sample an arm that moves; they then have times, and show the command of the row before.

    """

    arm: Arm
    camera: Camera | None
    plane_z_mm: float
    markers: tuple[str, ...]
    q_cmd: Array
    time_s: Array | None
    trajectory: NDArray[np.str_]
    payload_kg: Array
    temperature_c: Array | None
    links: Complex
    commanded_s: Array | None = None
    moving: bool = False

    def __len__(self) -> int:
        return len(self.q_cmd)

    def at(self, rows: NDArray[np.int64]) -> Context:
        """Return the context of some rows (K,) alone."""

        def some(values: Array | None) -> Array | None:
            return None if values is None else values[rows]

        return replace(
            self,
            q_cmd=self.q_cmd[rows],
            time_s=some(self.time_s),
            trajectory=self.trajectory[rows],
            payload_kg=self.payload_kg[rows],
            temperature_c=some(self.temperature_c),
            commanded_s=some(self.commanded_s),
        )

    @cached_property
    def commands(self) -> CommandSeries:
        """The commands with the times at which they were given and seen: what remembers steps through them."""
        if not self.moving:
            return settled_commands(self.q_cmd, self.time_s, self.commanded_s)
        if self.time_s is None:
            raise ValueError("a moving arm's rows have times")
        return moving_commands(self.q_cmd, self.time_s, self.commanded_s)

    @cached_property
    def clock(self) -> Array:
        """(N,) progress through the recording, 0 to 1, by time where it is known and by order otherwise."""
        ticks = np.arange(len(self), dtype=float) if self.time_s is None else self.time_s
        span = ticks[-1] - ticks[0]
        return (ticks - ticks[0]) / span if span > 0 else np.linspace(0.0, 1.0, len(self))

    @cached_property
    def elapsed_s(self) -> Array:
        """(N,) seconds since the first pose; one a pose where time was not recorded."""
        ticks = np.arange(len(self), dtype=float) if self.time_s is None else self.time_s - self.time_s[0]
        return ticks if ticks[-1] > 0 else np.arange(len(self), dtype=float)

    @cached_property
    def usual_wait_s(self) -> float:
        """Median time from a command to the sight of its row; one where time was not recorded."""
        middle = float(np.median(self.commands.waits_s))
        return middle if middle > 0 else 1.0

    @cached_property
    def relative_waits(self) -> Array:
        """(N,) time from each command to the sight of its row over the usual; ones where time was not recorded."""
        return self._over_the_usual(self.commands.waits_s)

    @cached_property
    def relative_spans(self) -> Array:
        """(N,) time from each command to the next over the usual wait; ones where time was not recorded."""
        return self._over_the_usual(self.commands.spans_s)

    def _over_the_usual(self, seconds: Array) -> Array:
        if self.time_s is None or not np.median(self.commands.waits_s) > 0:
            return np.ones(len(self))
        return np.clip(seconds / self.usual_wait_s, 0.05, 20.0)

    def followed_by(self, q_cmd: Array, name: str, payload_kg: Array | None = None) -> Context:
        """Return the context of these rows and then (K, n) commands, one usual wait apart.

        They carry `payload_kg` (K,), nothing where it is None, at the last temperature.
        """
        n = len(q_cmd)
        time, given, warm = self.time_s, self.commanded_s, self.temperature_c
        period = float(np.median(np.diff(self.commands.seen_s))) if len(self) > 1 else self.usual_wait_s
        if time is not None:
            later = time[-1] + period * np.arange(1, n + 1)
            given = None if given is None else np.append(given, later - self.usual_wait_s)
            time = np.append(time, later)
        return replace(
            self,
            q_cmd=np.concatenate([self.q_cmd, q_cmd]),
            time_s=time,
            commanded_s=given,
            trajectory=np.append(self.trajectory, np.full(n, name)),
            payload_kg=np.append(self.payload_kg, np.zeros(n) if payload_kg is None else payload_kg),
            temperature_c=None if warm is None else np.append(warm, np.full(n, warm[-1])),
        )

    @cached_property
    def turns_back(self) -> bool:
        """Whether some joint ever turns back, or none moves at all."""
        moves = np.diff(self.q_cmd, axis=0)
        ways = [np.unique(np.sign(way[np.abs(way) > STILL_RAD])) for way in moves.T]
        return any(len(way) > 1 for way in ways) or not any(len(way) for way in ways)

    @cached_property
    def has_gravity(self) -> bool:
        """Whether gravity pulls in the arm's plane."""
        return bool(np.linalg.norm(self.arm.gravity_m_s2) > 1e-3)

    @cached_property
    def masses_kg(self) -> tuple[Array, float]:
        """(n,) link masses and the tip's mass, typical ones where the recording names none."""
        links = self.arm.link_masses_kg
        tip = self.arm.tip_mass_kg
        return (
            np.full(self.arm.n_joints, TYPICAL_LINK_MASS_KG) if links is None else links,
            TYPICAL_TIP_MASS_KG if tip is None else tip,
        )

    def directions(self, q: Array) -> Complex:
        """(N, n) unit complex direction of each link for (N, n) joint angles."""
        out: Complex = np.exp(1j * np.cumsum(q + self.arm.zero_pose_rad, axis=-1))
        return out

    def gravity_torque(self, q: Array, link_masses_kg: Array, tip_mass_kg: Array) -> Array:
        """(N, n) torque of gravity about each joint, N m, counter-clockwise positive.

        Links carry their mass at their middle; `tip_mass_kg` is (N,) or a scalar.
        """
        spans = self.links * self.directions(q) * 1e-3  # mm to m: torques are SI
        g = complex(*self.arm.gravity_m_s2)
        # First moments of all that lies beyond each joint, summed from the tip inwards.
        beyond = np.broadcast_to(np.asarray(tip_mass_kg, dtype=float), spans.shape[:1])
        moment = np.zeros(spans.shape[0], dtype=complex)
        torque = np.empty(spans.shape)
        for joint in range(spans.shape[1] - 1, -1, -1):
            moment = moment + spans[:, joint] * (beyond + 0.5 * link_masses_kg[joint])
            beyond = beyond + link_masses_kg[joint]
            torque[:, joint] = (np.conj(moment) * g).imag
        return torque

    def declared_torque(self, q: Array) -> Array:
        """(N, n) torque of gravity by the declared masses and payload, N m."""
        links, tip = self.masses_kg
        return self.gravity_torque(q, links, tip + self.payload_kg)


def nominal_links(arm: Arm) -> Complex:
    """(n,) complex link lengths of the drawing, mm."""
    return complex_links(arm)
