"""The arm in MuJoCo, moved pose by pose and settled.

A servo holds its angle by a loop of finite stiffness, so a load moves it off. At rest the ideal servo takes that
droop out (the integral part of its controller, here in rounds of `_TRIM_ROUNDS` at rest, since an integral that ran
during the move would overshoot, and play and friction remember an overshoot). So nothing is left in a world without
effects; what is to give gives in a spring beyond the servo.

    time  ->   | ramp at approach speed | loop settles | trim | settles | picture

Once it rests the arm stays as it is until the next command, however long that takes. Where a world's pictures do not
wait for rest, the time from command to picture, and from there to the next command, is what the clock says.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import mujoco
import numpy as np
from numpy.typing import NDArray

from armtwin.models.commands import settled_commands
from armtwin.models.mjcf import add_tip_mass, build_arm
from armtwin.models.units import MM_PER_M
from armtwin.models.world import POSE_PERIOD_S, Command, World
from armtwin.sim.physics.placements import placements

Array = NDArray[np.float64]

# Steps between two looks at the arm: 40 ms, two loop times.
_CHUNK = 20
# At rest: what is left to go is this speed times the loop's 20 ms, so 2e-6 rad.
_REST_RAD_S = 1e-4
# A servo that takes minutes to arrive goes this slowly when a millionth of a radian is left.
_STILL_RAD_S = 1e-8
_TRIM_ROUNDS = 8
# Where MuJoCo keeps the slew limit of a PID actuator.
_SLEW_SLOT = 1
_TRIM_DONE_RAD = 2e-6
# A pose takes at most this long: a full turn at approach speed, and as much again to settle.
_LONGEST_MOVE_S = 8.0


class ArmSimulation:
    """One run of a world's arm from its home pose (all joints commanded to zero)."""

    def __init__(self, world: World) -> None:
        self.world = world
        self.model = world.compile()
        self.data = mujoco.MjData(self.model)
        self.marker_names = world.arm.known_markers
        joints = [self.model.joint(f"joint{i + 1}") for i in range(world.arm.n_joints)]
        self._motor_qpos = np.array([int(joint.qposadr[0]) for joint in joints])
        self._sites = np.array([self.model.site(f"marker_{name}").id for name in self.marker_names])
        self._tip = int(self.model.body(f"end{world.arm.n_joints}").id)
        self._relief = _Relief(world, self.model) if world.relieved else None
        self._electronics = [make() for make in world.electronics]
        self._happened = 0
        self._started = False
        self._seen_s = 0.0
        self._events = sorted(world.events, key=lambda event: event.sample)
        self._trim = np.zeros(world.arm.n_joints)
        self._payload_kg = 0.0
        mujoco.mj_forward(self.model, self.data)
        self._hold(np.zeros(world.arm.n_joints))

    def move(
        self,
        q_cmd: Array,
        sample: int = 0,
        given_s: float | None = None,
        payload_kg: float = 0.0,
        seen_s: float | None = None,
    ) -> None:
        """Send the arm to (n,) rad as pose `sample` at `given_s`, with `payload_kg` hung at its tip.

        Returns at the moment of the picture, `seen_s`. By default a command follows the picture before it at once, and
        is seen after the world's usual time. At its first pose a bench always waits until the arm rests.
        """
        given = self._seen_s if given_s is None else given_s
        seen = given + self.world.pose_period_s if seen_s is None else seen_s
        if self._started and not self.world.waits_for_rest:
            self._pass(given - self._seen_s)
        self._let_happen(sample)
        self.hang(payload_kg)
        self._send(q_cmd, sample, given)
        if self.world.waits_for_rest or not self._started:
            self._settle()
        else:
            self._pass(seen - given)
        self._started, self._seen_s = True, seen
        mujoco.mj_kinematics(self.model, self.data)

    def drive(self, q_cmd: Array, seconds: float) -> None:
        """Send one of a stream of commands, (n,) rad, and let `seconds` pass, for an arm that is filmed as it moves.

        The integral part of the servos works whenever the arm is at rest, so that it comes to stand where `move` would
        have left it. Stages that count poses know of pose 0 only.
        """
        self._send(q_cmd, 0, float(self.data.time))
        self._run_for(max(1, round(seconds / self.model.opt.timestep)))
        if np.abs(self.data.qvel).max() < _REST_RAD_S:
            self._trim += self._target - self.data.qpos[self._motor_qpos]
        mujoco.mj_kinematics(self.model, self.data)

    def approach_at(self, speed_rad_s: float) -> None:
        """Let the servos approach commands at another speed."""
        self.model.actuator_dynprm[:, _SLEW_SLOT] = speed_rad_s

    def hang(self, payload_kg: float) -> None:
        """Hang a known mass at the tip instead of the one that hangs there."""
        add_tip_mass(self.model, self._tip, payload_kg - self._payload_kg)
        self._payload_kg = payload_kg

    def markers_mm(self) -> Array:
        """(M, 3) centres of the stickers in the robot frame, mm, in the order of `marker_names`."""
        points: Array = self.data.site_xpos[self._sites] * MM_PER_M
        return points

    def bodies(self) -> dict[str, Array]:
        """(4, 4) transforms, mm, that map the coordinates of each body (`link1`, `end1`, ...) to the robot frame."""
        return placements(self.model, self.data)

    def joint_angles(self) -> Array:
        """(n,) angle of each link against the one before it, less its drawn zero pose, rad: what a protractor reads."""
        bodies = self.bodies()
        x_axes = np.array([bodies[f"link{i + 1}"][:2, 0] for i in range(self.world.arm.n_joints)])
        heading = np.arctan2(x_axes[:, 1], x_axes[:, 0])
        turned = np.diff(heading, prepend=0.0) - self.world.arm.zero_pose_rad
        return np.pi - np.mod(np.pi - turned, 2 * np.pi)

    def _send(self, q_cmd: Array, sample: int, time_s: float) -> None:
        q = np.array(q_cmd, dtype=float)
        for stage in self._electronics:
            q = stage(Command(sample, time_s, q))
        self._target = q
        self.data.ctrl[:] = q + self._trim

    def _hold(self, q: Array) -> None:
        self._target = q
        self.data.ctrl[:] = q
        self._settle()

    def _settle(self) -> None:
        self._run_to_rest()
        for _ in range(_TRIM_ROUNDS):
            droop = self._target - self.data.qpos[self._motor_qpos]
            if np.abs(droop).max() < _TRIM_DONE_RAD:
                return
            self._trim += droop
            self.data.ctrl[:] = self._target + self._trim
            self._run_to_rest()

    def _run_to_rest(self) -> None:
        for _ in range(int(_LONGEST_MOVE_S / (_CHUNK * self.model.opt.timestep))):
            self._run_for(_CHUNK)
            if np.abs(self.data.qvel).max() < _REST_RAD_S:
                return

    def _pass(self, seconds: float) -> None:
        """Let time pass; an arm that stands still is where it will be then."""
        left = round(seconds / self.model.opt.timestep)
        while left > 0:
            self._run_for(min(_CHUNK, left))
            left -= _CHUNK
            if np.abs(self.data.qvel).max() < _STILL_RAD_S:
                return

    def _run_for(self, steps: int) -> None:
        if self._relief is None:
            mujoco.mj_step(self.model, self.data, steps)
            return
        for done in range(0, steps, _CHUNK):
            self._relief.carry(self.data, self.data.qpos[self._motor_qpos])
            mujoco.mj_step(self.model, self.data, min(_CHUNK, steps - done))

    def _let_happen(self, sample: int) -> None:
        while self._happened < len(self._events) and self._events[self._happened].sample <= sample:
            self._events[self._happened].happen(self.model, self.data)
            self._happened += 1


class _Relief:
    """Carries the static load of the arm's own mass past the relieved hinges."""

    def __init__(self, world: World, model: mujoco.MjModel) -> None:
        self._model = build_arm(world.arm, world.servo, world.deviation).compile()
        self._data = mujoco.MjData(self._model)
        hinges = [model.joint(name) for name in world.relieved]
        self._dofs = np.array([int(hinge.dofadr[0]) for hinge in hinges])
        # A hinge in series shares the axis, and so the load, of its body's servo.
        self._joints = np.array([int(model.body(int(hinge.bodyid[0])).jntadr[0]) for hinge in hinges])
        first = {int(model.joint(f"joint{i + 1}").id): i for i in range(world.arm.n_joints)}
        self._servos = np.array([first[joint] for joint in self._joints])

    def carry(self, data: mujoco.MjData, q: Array) -> None:
        """Apply at the relieved hinges of `data` the torque that holds the rigid arm at servo angles `q`."""
        self._data.qpos[:] = q
        mujoco.mj_forward(self._model, self._data)
        data.qfrc_applied[self._dofs] = self._data.qfrc_bias[self._servos]


def simulate(
    world: World,
    q_cmd: Array,
    time_s: Array | None = None,
    payload_kg: Array | Sequence[float] | None = None,
    commanded_s: Array | None = None,
) -> Array:
    """Run (N, n) commands, rad, in their order; return (N, M, 3) sticker centres in the robot frame, mm.

    They are seen at `time_s` (N,), by default one usual time after another, and given at `commanded_s` (N,), by default
    when the pose before was seen. `payload_kg` (N,) is the known mass hung at the tip.
    """
    return _run(world, q_cmd, time_s, payload_kg, commanded_s, ArmSimulation.markers_mm)


def simulate_angles(
    world: World,
    q_cmd: Array,
    time_s: Array | None = None,
    payload_kg: Array | Sequence[float] | None = None,
    commanded_s: Array | None = None,
) -> Array:
    """Run commands as `simulate` does; return (N, n) angles of the links, rad: what a protractor reads."""
    return _run(world, q_cmd, time_s, payload_kg, commanded_s, ArmSimulation.joint_angles)


def _run(
    world: World,
    q_cmd: Array,
    time_s: Array | None,
    payload_kg: Array | Sequence[float] | None,
    commanded_s: Array | None,
    look: Callable[[ArmSimulation], Array],
) -> Array:
    """(N, ...) what `look` sees at every pose."""
    n = len(q_cmd)
    seen_s = default_clock(n, world.pose_period_s) if time_s is None else time_s
    commands = settled_commands(q_cmd, seen_s, commanded_s)
    payloads = np.zeros(n) if payload_kg is None else np.asarray(payload_kg, dtype=float)
    arm = ArmSimulation(world)
    seen = []
    for sample in range(n):
        given, sight = float(commands.given_s[sample]), float(commands.seen_s[sample])
        arm.move(q_cmd[sample], sample, given, float(payloads[sample]), sight)
        seen.append(look(arm))
    return np.array(seen)[np.clip(np.arange(n) - world.picture_lag, 0, n - 1)]


def default_clock(n: int, period_s: float = POSE_PERIOD_S) -> Array:
    """(n,) times of poses that follow one another every `period_s`."""
    return np.arange(n, dtype=float) * period_s
