"""Commands that bring the real arm where a plan wants it, found by trial on its extended twin.

The twin is run through the commands in MuJoCo, they are moved by what the arm missed, and it is run again, the whole
plan at once: with play, friction or lag a pose depends on all before it. Where an effect cannot be undone (coarse
steps, a dead band) the commands of the run that missed least are kept.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from armtwin.models.catalogue.injection import shifted_samples
from armtwin.models.catalogue.registry import effect_named
from armtwin.models.errors import InputError
from armtwin.models.kinematics import forward, wrap
from armtwin.models.plan import ROUNDING_RAD, Plan
from armtwin.models.reach import reach, tip_errors, tip_slopes
from armtwin.models.tabular import html_table
from armtwin.models.twin import Twin, rebuild
from armtwin.models.wanted_path import WantedPath
from armtwin.models.world import World
from armtwin.sim.physics.simulation import ArmSimulation

Array = NDArray[np.float64]

_ITERATIONS = 15
# A step of a hobby servo's pulses, 1 us, is 1.6 mrad: a hundredth of that is nothing to go on for.
_CLOSED_RAD = 2e-5
_CLOSED_MM = 2e-3
# What happened at some sample of the recording has happened by now.
_AFTER_THE_RECORDING = 1_000_000
# Faults of seeing leave the arm where it is.
_OF_THE_ARM = ("joint", "link", "arm")


@dataclass(frozen=True, eq=False)
class Correction:
    """Corrected commands, and what the twin expects of them.

    Attributes:
        plan: the commands for the rows that can be reached.
        rows: (K,) numbers of these rows in what was wanted.
        before_mm, after_mm: (K,) distance of the tip from where it should be, with the drawing's commands and these.
        before_rad, after_rad: (K,) largest error of a joint where joint poses were wanted, else None.
        out_of_reach: places of the rows that the arm cannot reach, with how much is missing, mm.
        notes: what the expectation leaves out.

    """

    plan: Plan
    rows: NDArray[np.intp]
    before_mm: Array
    after_mm: Array
    before_rad: Array | None
    after_rad: Array | None
    out_of_reach: tuple[tuple[str, float], ...]
    notes: tuple[str, ...]

    def columns(self) -> dict[str, NDArray[Any]]:
        """Return the commands with the errors before and expected after, a row a pose."""
        commands = {f"theta{i + 1}_cmd_rad": self.plan.q_cmd[:, i] for i in range(self.plan.q_cmd.shape[1])}
        errors = {"before_mm": self.before_mm, "after_mm": self.after_mm}
        return {"trajectory": self.plan.trajectory, **commands, **errors}

    def _repr_html_(self) -> str:
        before, after = (float(np.sqrt(np.mean(values**2))) for values in (self.before_mm, self.after_mm))
        return html_table(f"Corrected plan: {before:.3g} → {after:.3g} mm expected", self.columns())


def correct(twin: Twin, wanted: WantedPath) -> Correction:
    """Return commands for the wanted poses; raises `InputError` where none of them can be reached."""
    deviation = twin.deviation
    lost: tuple[tuple[str, float], ...] = ()
    if wanted.q is not None:
        rows, drawn, start = np.arange(len(wanted)), wanted.q, wanted.q - deviation.joints_rad
        goal = forward(twin.arm, start, deviation)
    else:
        assert wanted.tip_mm is not None
        built = reach(twin.arm, wanted.tip_mm, wanted.theta_rad, deviation)
        rows = np.flatnonzero(built.reached)
        lost = tuple((wanted.places[row], float(built.missed_mm[row])) for row in np.flatnonzero(~built.reached))
        if not len(rows):
            raise InputError(f"no point can be reached; the nearest is {min(built.missed_mm):.1f} mm out of reach")
        theta = None if wanted.theta_rad is None else wanted.theta_rad[rows]
        drawing = reach(twin.arm, wanted.tip_mm[rows], theta)
        start = built.q[rows]
        drawn = np.where(drawing.reached[:, None], drawing.q, start)
        goal = np.column_stack([wanted.tip_mm[rows], np.full(len(rows), np.nan) if theta is None else theta])
    bench = _Bench(_world(twin), wanted.payload_kg[rows])
    aim = _Aim(twin, goal, None if wanted.q is None else wanted.q)
    before = bench.run(drawn)
    command, after = _iterate(bench, aim, start)
    angles = wanted.q is not None
    return Correction(
        plan=Plan(wanted.trajectory[rows], command, wanted.payload_kg[rows]),
        rows=rows,
        before_mm=aim.miss_mm(before),
        after_mm=aim.miss_mm(after),
        before_rad=aim.miss_rad(before) if angles else None,
        after_rad=aim.miss_rad(after) if angles else None,
        out_of_reach=lost,
        notes=(*_notes(twin), *_beyond_limits(twin, command)),
    )


@dataclass(frozen=True, eq=False)
class _Run:
    """Where the twin came to stand: (N, n) link angles, rad, and (N, 3) tip, mm, mm, rad."""

    q: Array
    tip: Array


@dataclass(frozen=True, eq=False)
class _Bench:
    world: World
    payload_kg: Array

    def run(self, q_cmd: Array) -> _Run:
        arm = ArmSimulation(self.world)
        end = f"end{self.world.arm.n_joints}"
        angles, tips = [], []
        for sample, q in enumerate(q_cmd):
            arm.move(q, sample, payload_kg=float(self.payload_kg[sample]))
            angles.append(arm.joint_angles())
            tips.append(arm.bodies()[end][:2, 3])
        q = np.array(angles)
        theta = forward(self.world.arm, q)[:, 2:]
        return _Run(q, np.concatenate([np.array(tips), theta], axis=1))


@dataclass(frozen=True, eq=False)
class _Aim:
    twin: Twin
    goal: Array
    q: Array | None

    def step(self, run: _Run, command: Array) -> Array:
        """(N, n) by how much to move the commands."""
        if self.q is not None:
            return wrap(self.q - run.q)
        theta = None if np.isnan(self.goal[:, 2]).all() else self.goal[:, 2]
        errors = tip_errors(self.goal[:, :2], theta, run.tip)
        slopes = tip_slopes(self.twin.arm, command, theta is not None, self.twin.deviation)
        out: Array = np.einsum("nij,nj->ni", np.linalg.pinv(slopes, rcond=1e-3), errors)
        return out

    def miss_mm(self, run: _Run) -> Array:
        out: Array = np.linalg.norm(self.goal[:, :2] - run.tip[:, :2], axis=1)
        return out

    def miss_rad(self, run: _Run) -> Array:
        assert self.q is not None
        out: Array = np.abs(wrap(self.q - run.q)).max(axis=1)
        return out

    def cost(self, run: _Run) -> Array:
        """(N,) what each row misses, in units of what is small enough."""
        if self.q is not None:
            return self.miss_rad(run) / _CLOSED_RAD
        theta = None if np.isnan(self.goal[:, 2]).all() else self.goal[:, 2]
        out: Array = np.linalg.norm(tip_errors(self.goal[:, :2], theta, run.tip), axis=1) / _CLOSED_MM
        return out


def _iterate(bench: _Bench, aim: _Aim, command: Array) -> tuple[Array, _Run]:
    run = bench.run(command)
    best, best_run = command, run
    for _ in range(_ITERATIONS):
        if aim.cost(best_run).max() < 1.0:
            break
        command = command + np.clip(aim.step(run, command), -0.2, 0.2)
        run = bench.run(command)
        if np.linalg.norm(aim.cost(run)) < np.linalg.norm(aim.cost(best_run)):
            best, best_run = command, run
    return best, best_run


def _world(twin: Twin) -> World:
    """Return the arm as it stands after the recording, waited for until it rests."""
    kept = []
    for effect in twin.effects:
        known = effect_named(effect.effect)
        if known.where in _OF_THE_ARM:
            parameters = shifted_samples(known.injected, effect.parameters, twin.arm, _AFTER_THE_RECORDING)
            kept.append(replace(effect, parameters=parameters))
    return replace(rebuild(replace(twin, effects=tuple(kept))), waits_for_rest=True, picture_lag=0, detections=())


def _beyond_limits(twin: Twin, command: Array) -> tuple[str, ...]:
    """Say which joints would be turned further by (N, n) commands, rad, than the drawing lets them."""
    if twin.arm.joint_limits_rad is None:
        return ()
    low, high = twin.arm.joint_limits_rad.T
    beyond = ((command < low - ROUNDING_RAD) | (command > high + ROUNDING_RAD)).sum(axis=0)
    return tuple(
        f"{label} is commanded beyond its limits, {low[joint]:g} to {high[joint]:g} rad, in {beyond[joint]} of "
        f"{len(command)} rows"
        for joint, label in enumerate(twin.arm.joint_labels)
        if beyond[joint]
    )


def _notes(twin: Twin) -> tuple[str, ...]:
    known = {effect.effect: effect_named(effect.effect).when_correcting for effect in twin.effects}
    return tuple(f"{name}: {note}" for name, note in known.items() if note is not None)
