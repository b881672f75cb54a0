"""Draw a sealed log: an arm, motions, and effects large enough to show above the noise, moved by MuJoCo."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from armtwin.models.catalogue.motion_effect import motion_catalogue
from armtwin.models.catalogue.motion_injection import inject_in_motion
from armtwin.models.catalogue.site import NOWHERE, Site
from armtwin.models.errors import InputError, JobError, nearest, shown
from armtwin.models.motion_world import Motion, MotionWorld, Reading, ideal_motion_world
from armtwin.sim.motion.simulation import simulate_motion
from armtwin.sim.sealed_motion.arms import DrawnArm, draw_arm, loads_nm
from armtwin.sim.sealed_motion.forms import FORMS, OF_LOAD, Situation
from armtwin.sim.sealed_motion.plans import draw_motions
from armtwin.sim.sealed_motion.strange import STRANGE

Array = NDArray[np.float64]

# Encoders of 10, 12 and 14 bits a turn, and one that reads on without a grain.
_COUNTS_PER_TURN = (1024, 4096, 4096, 16384, 0)
_NOISE_RAD = (1.5e-4, 1.0e-3)
_ZERO_RAD = 0.03
# An effect moves the rows that it touches by so many noises or it is drawn anew, larger; of what no catalogue
# describes much has to be seen before anyone can say so.
_LEAST_NOISES = 5.0
_LEAST_STRANGE_NOISES = 8.0
_GROWS = 1.6
_ATTEMPTS = 10
_TOUCHED = 0.1
_FEWEST_ROWS = 8


@dataclass(frozen=True, eq=False)
class SealedLog:
    """A log, and the truth about it as plain data.

    Attributes:
        arm: with its table and maybe its model.
        motions: what was commanded.
        q_meas: (N, n) readings, rad.
        held_out: names of motions for the log's header.
        truth: what is hidden.

    """

    arm: DrawnArm
    motions: list[Motion]
    q_meas: Array
    held_out: tuple[str, ...]
    truth: dict[str, Any]


@dataclass(frozen=True, eq=False)
class _Bench:
    drawn: DrawnArm
    world: MotionWorld
    motions: list[Motion]
    held_out: tuple[str, ...]
    clean: Array
    noise_rad: Array
    situation: Situation


def draw_log(rng: Generator, effects: Sequence[str] = (), *, n_rows: int | None = None) -> SealedLog:
    """Draw a log with effects of the catalogue, by name, or one of `STRANGE`, hidden in it.

    Raises `InputError` for an unknown effect and `JobError` where none of the draws shows above the noise.
    """
    for name in effects:
        if name not in FORMS and name not in STRANGE:
            known = [*FORMS, *STRANGE]
            raise InputError(f"no effect '{shown(name)}' can be hidden in a moving arm{nearest(name, known)}")
    for _ in range(_ATTEMPTS):
        grain, noise = int(rng.choice(_COUNTS_PER_TURN)), float(np.exp(rng.uniform(*np.log(_NOISE_RAD))))
        bench = _bench(rng, effects, n_rows, grain, noise)
        taken: list[tuple[str, int | None]] = []
        world, hidden = bench.world, []
        for name in effects:
            found = _hidden(rng, bench, name, taken)
            if found is None:
                break
            taken.append((name, found["joint"]))
            hidden.append(found)
            world = _made(world, found)
        if len(hidden) == len(effects):
            return _recorded(rng, bench, world, hidden, grain, noise)
    raise JobError(f"no log in {_ATTEMPTS} draws in which {' and '.join(effects)} shows above the noise")


def _bench(rng: Generator, effects: Sequence[str], n_rows: int | None, grain: int, noise: float) -> _Bench:
    least = 1 if len(effects) < 2 else 2
    n_joints = int(rng.integers(least, 7))
    drawn = draw_arm(rng, n_joints, any(name in OF_LOAD for name in effects))
    zeros = rng.uniform(-_ZERO_RAD, _ZERO_RAD, n_joints) * (rng.random() < 0.5)
    world = ideal_motion_world(drawn.arm, zeros)
    rows = int(rng.integers(1500, 4000)) if n_rows is None else n_rows
    motions, held_out = draw_motions(rng, n_joints, rows)
    time_s = np.concatenate([motion.time_s for motion in motions])
    q_cmd = np.concatenate([motion.q_cmd for motion in motions])
    width = 2 * np.pi / grain if grain else 0.0
    in_all = np.full(n_joints, np.hypot(noise, width / np.sqrt(12.0)))
    loads = loads_nm(drawn.arm, q_cmd)
    situation = Situation(time_s, q_cmd, loads, world.servo.stiffness_nm_rad)
    return _Bench(drawn, world, motions, held_out, simulate_motion(world, motions), in_all, situation)


def _hidden(rng: Generator, bench: _Bench, name: str, taken: Sequence[tuple[str, int | None]]) -> dict[str, Any] | None:
    """Draw an effect at a place where nothing that is confused with it sits, as large as it has to be."""
    joint = _place(rng, bench, name, taken)
    if joint is not None and joint < 0:
        return None
    strange = name in STRANGE
    least = _LEAST_STRANGE_NOISES if strange else _LEAST_NOISES
    size, seed = 1.0, int(rng.integers(2**32))
    for _ in range(_ATTEMPTS):
        index = 0 if joint is None else joint - 1
        generator = np.random.default_rng(seed)
        parameters = {"size": size, "seed": seed} if strange else FORMS[name](generator, bench.situation, index, size)
        found = {"effect": name, "joint": joint, "marker": None, "parameters": parameters}
        moved = _moved(bench, _made(bench.world, found))
        worst = int(np.argmax(moved / bench.noise_rad))
        noises = float(moved[worst] / bench.noise_rad[worst])
        if noises >= least:
            return {**found, "moved_rad": float(moved[worst]), "moved_noises": noises}
        size *= _GROWS
    return None


def _place(rng: Generator, bench: _Bench, name: str, taken: Sequence[tuple[str, int | None]]) -> int | None:
    """Number of a joint from 1; None for the whole arm; -1 where there is no place."""
    n = bench.world.arm.n_joints
    catalogue = motion_catalogue()
    if name in catalogue and catalogue[name].where == "arm":
        return None
    if name == "latency" and not taken and rng.random() < 0.25 and n > 1:
        return None
    free = []
    for joint in range(1, n + 1):
        if name in OF_LOAD and bench.situation.loads_nm[joint - 1] < 0.05:
            continue
        if all(at != joint or not _alike(name, other) for other, at in taken):
            free.append(joint)
    return int(rng.choice(free)) if free else -1


def _alike(one: str, other: str) -> bool:
    known = motion_catalogue()
    if one not in known or other not in known:
        return False
    return one == other or one in known[other].confused_with or other in known[one].confused_with


def _made(world: MotionWorld, found: dict[str, Any]) -> MotionWorld:
    name, joint, parameters = found["effect"], found["joint"], found["parameters"]
    if name in STRANGE:
        index = 0 if joint is None else joint - 1
        return STRANGE[name](np.random.default_rng(parameters["seed"]), world, index, parameters["size"])
    return inject_in_motion(world, name, parameters, NOWHERE if joint is None else Site(joint=joint))


def _moved(bench: _Bench, world: MotionWorld) -> Array:
    """(n,) RMS, rad, by which a world moves the rows that it touches, but for what a zero would take up."""
    off = simulate_motion(world, bench.motions, rng=np.random.default_rng(1)) - bench.clean
    off -= np.median(off, axis=0)
    shown_rows = ~np.isin(_names(bench.motions), bench.held_out)
    moved = np.zeros(off.shape[1])
    for joint, column in enumerate(np.abs(off[shown_rows]).T):
        touched = column[column > max(_TOUCHED * column.max(), 1e-6)] if column.size else column
        if len(touched) >= _FEWEST_ROWS:
            moved[joint] = float(np.sqrt(np.mean(touched**2)))
    return moved


def _recorded(
    rng: Generator, bench: _Bench, world: MotionWorld, hidden: list[dict[str, Any]], grain: int, noise: float
) -> SealedLog:
    # What garbles or repeats readings does it to what the encoders said.
    world = replace(world, readings=(_encoders(grain, noise), *world.readings))
    q = simulate_motion(world, bench.motions, rng=rng)
    truth = {
        "effects": hidden,
        "n_rows": len(q),
        "n_joints": q.shape[1],
        "noise_rad": bench.noise_rad.tolist(),
        "counts_per_turn": grain,
        "zeros_rad": bench.world.zeros_rad.tolist(),
    }
    held_out = bench.held_out if rng.random() < 0.5 else ()
    return SealedLog(bench.drawn, bench.motions, q, held_out, truth)


def _encoders(grain: int, noise: float) -> Reading:
    """Read with noise, rad, in `grain` counts a turn (0: without steps), from an origin of each joint's own."""

    def read(time_s: Array, q: Array, rng: Generator) -> Array:
        q = q + noise * rng.standard_normal(q.shape)
        if not grain:
            return q
        width = 2 * np.pi / grain
        origin = rng.uniform(0.0, width, q.shape[1])
        return np.asarray(origin + width * np.round((q - origin) / width))

    return read


def _names(motions: Sequence[Motion]) -> NDArray[np.str_]:
    return np.concatenate([np.full(len(motion.time_s), motion.name) for motion in motions])
