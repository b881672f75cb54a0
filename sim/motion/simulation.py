"""The arm in MuJoCo, moved by a stream of commands and read at times.

    row 0      row 1      row 2            the reading of a row is taken before its command acts;
    read       read       read             what a wire delays acts later, between rows
      | command 0 | command 1 | command 2

Steps end at every row and wherever a command reaches a drive, and are at most 1 ms long.
"""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from armtwin.models.motion_world import Disturbance, Motion, MotionWorld, Wire
from armtwin.sim.motion.drive import DriveBank
from armtwin.sim.motion.model import LONGEST_STEP_S, compiled

Array = NDArray[np.float64]

# Commands that come nearer than this after one another come at once: at full speed a joint turns 0.06 mrad meanwhile.
_AT_ONCE_S = 1e-5
# Loads change slowly: at 6 rad/s a joint turns 0.02 rad meanwhile.
_STEPS_OF_A_LOAD = 4
# After this the arm stands still wherever the last command has sent it, so that a longer wait need not be simulated.
_LONGEST_WAIT_S = 5.0


def simulate_motion(
    world: MotionWorld,
    motions: Sequence[Motion],
    starts: Sequence[Array | None] | Array | None = None,
    rng: Generator | None = None,
) -> Array:
    """Move the arm through motions, one after the other; return the readings (N, n), rad, of all their rows.

    Times grow over all motions, and a command stays in force until the next, over the gaps too. `starts` says for each
    motion where the arm is put before its first row, (n,) rad as it reads, or None where it stays as it is; the first
    one without a start rests at its first command. `rng` is for what goes wrong at random.
    """
    time_s = np.concatenate([motion.time_s for motion in motions])
    q_cmd = np.concatenate([motion.q_cmd for motion in motions])
    run = MotionRun(world, time_s, q_cmd)
    first_rows = np.cumsum([0, *(len(motion.time_s) for motion in motions)])[:-1]
    put = {
        int(row): np.asarray(start, dtype=float)
        for row, start in zip(first_rows, starts if starts is not None else (), strict=False)
        if start is not None
    }
    readings = np.empty_like(q_cmd)
    for row in range(len(time_s)):
        run.advance_to(time_s[row])
        if row in put:
            run.put(put[row])
        readings[row] = run.reading()
    generator = np.random.default_rng(0) if rng is None else rng
    for stage in world.readings:
        readings = stage(time_s, readings, generator)
    return readings


class MotionRun:
    """One run of a world's arm through a stream of commands (N, n), rad, given at `time_s` (N,)."""

    def __init__(self, world: MotionWorld, time_s: Array, q_cmd: Array) -> None:
        self.world = world
        n = world.arm.n_joints
        self._bank = DriveBank(world.drives, world.servo.stiffness_nm_rad)
        self.model = compiled(world, self._bank.has_friction)
        self.data = mujoco.MjData(self.model)
        joints = [self.model.joint(name) for name in world.arm.joints]
        self._qpos = np.array([int(joint.qposadr[0]) for joint in joints])
        self._dofs = np.array([int(joint.dofadr[0]) for joint in joints])
        self._encoders = [
            np.array(
                [self._qpos[i], *(int(self.model.joint(name).qposadr[0]) for name in world.series_hinges.get(i, ()))]
            )
            for i in range(n)
        ]
        self._bodies = [int(joint.bodyid[0]) for joint in joints]
        self._wires = wired(world, time_s, q_cmd)
        self._next = np.zeros(n, dtype=int)
        self._target = np.zeros(n)
        self._slipped = np.zeros(n)
        self._slips = sorted(world.slips, key=lambda slip: slip.time_s)
        self._tip = self.model.body(world.arm.tip).id
        self._jacobian = np.zeros((3, self.model.nv))
        self._disturbances: list[Disturbance] = [make() for make in world.disturbances]
        self._acts = bool(self._disturbances)
        self._step_s = 0.0
        self._damping = self._armature = np.zeros(n)
        self._arrivals = np.unique(
            np.concatenate([*(wire.time_s[1:] for wire in self._wires), [s.time_s for s in self._slips]])
        )
        self.time_s = float(time_s[0])
        self._hear()
        self.data.qpos[self._qpos] = self._target
        self._prepare(LONGEST_STEP_S)
        mujoco.mj_forward(self.model, self.data)
        self._pass(0.5)  # loops that give under a load come to rest

    def put(self, reading: Array) -> None:
        """Put the arm at rest where it reads (n,) rad."""
        self.data.qpos[:] = 0.0
        self.data.qvel[:] = 0.0
        self.data.qpos[self._qpos] = reading - self.world.zeros_rad - self._slipped
        mujoco.mj_forward(self.model, self.data)

    def reading(self) -> Array:
        """(n,) what the encoders read, rad."""
        turned = np.array([self.data.qpos[places].sum() for places in self._encoders])
        out: Array = turned + self._slipped + self.world.zeros_rad
        return out

    def advance_to(self, time_s: float) -> None:
        """Let the arm move until `time_s`; what arrives at that very moment does not act yet."""
        if time_s - self.time_s > _LONGEST_WAIT_S:
            quiet = self._arrivals[(self._arrivals > self.time_s) & (self._arrivals < time_s)]
            if not len(quiet):
                self._pass(_LONGEST_WAIT_S)
                self.time_s = time_s
                return
        low, high = np.searchsorted(self._arrivals, [self.time_s - _AT_ONCE_S, time_s - _AT_ONCE_S])
        for moment in self._arrivals[low:high]:
            self._run_to(float(moment))
            self._hear()
        self._run_to(time_s)

    def _run_to(self, time_s: float) -> None:
        if time_s - self.time_s > _AT_ONCE_S:
            self._pass(time_s - self.time_s)
            self.time_s = time_s

    def _hear(self) -> None:
        """Let what has arrived by now act."""
        for i, wire in enumerate(self._wires):
            number = int(np.searchsorted(wire.time_s, self.time_s + _AT_ONCE_S, side="right")) - 1
            self._target[i] = wire.q[max(number, 0)]
        while self._slips and self._slips[0].time_s <= self.time_s + _AT_ONCE_S:
            slip = self._slips.pop(0)
            self._turn_on_horn(slip.joint, slip.jump_rad)

    def _turn_on_horn(self, joint: int, jump: float) -> None:
        body, axis = self._bodies[joint], self.model.joint(self.world.arm.joints[joint]).axis
        turn, seat = np.zeros(4), np.zeros(4)
        mujoco.mju_axisAngle2Quat(turn, axis, jump)
        mujoco.mju_mulQuat(seat, self.model.body_quat[body], turn)
        self.model.body_quat[body] = seat
        self._slipped[joint] += jump

    def _pass(self, seconds: float) -> None:
        steps = max(1, int(np.ceil(seconds / LONGEST_STEP_S - 1e-9)))
        h = seconds / steps
        self._prepare(h)
        if not (self._bank.feels_load or self._bank.feels_motion or self._acts):
            self.data.ctrl[:] = self._target
            mujoco.mj_step(self.model, self.data, steps)
            return
        at_once = 1 if self._bank.feels_motion or self._acts else _STEPS_OF_A_LOAD
        for k in range(0, steps, at_once):
            self._feel(self.time_s + k * h)
            mujoco.mj_step(self.model, self.data, min(at_once, steps - k))

    def _prepare(self, h: float) -> None:
        if abs(h - self._step_s) < 1e-12:
            return
        self._step_s = h
        self.model.opt.timestep = h
        self._damping, self._armature = self._bank.step(h)
        self.model.dof_damping[self._dofs] = self._damping
        self.model.dof_armature[self._dofs] = self._armature
        load = np.zeros(len(self._dofs))
        friction = self._bank.friction(load, load, load)
        self.model.actuator_forcerange[:] = self._bank.push_limits(self._damping, load, friction)
        if self._bank.has_friction:
            self.model.dof_frictionloss[self._dofs] = friction

    def _feel(self, now: float) -> None:
        """Let loads, speeds and what pushes at the drives act for one step."""
        drawn = self.data.qfrc_gravcomp[self._dofs]
        payload = self._payload_torque(now)
        load = drawn + payload
        speed = self.data.qvel[self._dofs]
        target = self._target - self._bank.droop(drawn, payload)
        for disturb in self._disturbances:
            target = target + disturb(now, self.data.qpos[self._qpos], speed, self._target)
        self.data.ctrl[:] = target
        friction = np.zeros(len(self._dofs))
        if self._bank.has_friction:
            driven = self.data.actuator_force - self._damping * speed
            friction = self._bank.friction(load, speed, driven)
            self.model.dof_frictionloss[self._dofs] = friction
        rotor = self._bank.rotor_reserve(self._armature, self._damping, speed, self._step_s)
        self.model.actuator_forcerange[:] = self._bank.push_limits(self._damping, load, friction, rotor)

    def _payload_torque(self, now: float) -> Array:
        """(n,) torque, N m, that holds the undeclared mass at the tip."""
        if self.world.payload_kg == 0.0 or now < self.world.payload_from_s:
            return np.zeros(len(self._dofs))
        mujoco.mj_jac(self.model, self.data, self._jacobian, None, self.data.xipos[self._tip], self._tip)
        weight = self.world.payload_kg * self.model.opt.gravity
        out: Array = -(self._jacobian.T @ weight)[self._dofs]
        return out


def wired(world: MotionWorld, time_s: Array, q_cmd: Array) -> list[Wire]:
    """Return what arrives at each drive; of each the first command has been in force for ever."""
    rows = np.arange(-1, len(time_s))
    given = np.append(-np.inf, time_s)
    wires = [Wire(given, np.append(q[0], q), rows) for q in q_cmd.T]
    for stage in world.wiring:
        wires = stage(wires)
    return wires
