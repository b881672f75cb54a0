"""Single poses at which the arm, or a joint of it, stayed where it was.

Known forms: a line of a serial stream that is lost, so that no joint moves; one servo's packet lost on a shared bus
(half-duplex TTL or RS-485: `SYNC_WRITE` is not answered, so nobody notices), so that the others move; a controller that
hangs for several poses. Covered: any set of joints at any pose, one pose or a run of them; what was missed is made up
for by the next command that arrives. Not covered: a joint that gets the command late, within the pose (`settling_lag`),
or another joint's.

A pose was missed where all that is seen agrees with some joints left where they were, and not with its own command.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from armtwin.models.catalogue import sealed
from armtwin.models.catalogue.context import Context
from armtwin.models.catalogue.injection import Injected, samples
from armtwin.models.catalogue.motion_effect import MotionEffect
from armtwin.models.catalogue.registry import Effect, Found, Site, Stage, View
from armtwin.models.motion_world import MotionWorld, Wire
from armtwin.models.world import Command, Electronics, World, samples_of

Array = NDArray[np.float64]

# What is seen must miss its own pose by this many standard deviations, and meet the one before within the other.
_MISSES = 8.0
_MEETS = 4.0
# Where one was missed, others that moved the arm less are believed; below this a pose tells nothing.
_MISSES_TOO = 5.0
# A run of missed poses is found one pose a look.
_LOOKS = 12
# Up to so many joints every set of them may have stayed; of longer arms one joint, two, or all.
_ANY_SET = 3
_OF_MORE = 2
# A value is its row where all joints stayed; where only some did, these follow as a fraction: bit j for joint j + 1.
_SETS = 128.0


def term(context: Context, q: Array, values: Array, site: Site) -> Array:
    """Commands of which those at the rows in `values` never reached the joints in them."""
    out = q.copy()
    for row, stayed in _rows_and_joints(values, q.shape[1]):
        out[row, stayed] = out[row - 1, stayed]
    return out


def find(context: Context, view: View) -> list[tuple[Site, Array]]:
    """Return the rows, and joints where some moved, that agree with the last executed pose and not with their own."""
    if view.replay is None:
        rows = _all_stayed(view)
        return [(Site(), np.array(rows, dtype=float))] if rows else []
    stayed = _stayed(context, view, np.zeros(context.q_cmd.shape, dtype=bool), _MISSES)
    if stayed.any():
        stayed = _stayed(context, view, stayed, _MISSES_TOO)
    rows = [_packed(row, stayed[row]) for row in np.flatnonzero(stayed.any(axis=1)).tolist()]
    return [(Site(), np.array(rows, dtype=float))] if rows else []


def _stayed(context: Context, view: View, stayed: NDArray[np.bool_], least: float) -> NDArray[np.bool_]:
    """(N, n) joints that stayed at poses that miss their own by at least so many standard deviations."""
    assert view.replay is not None
    n = context.q_cmd.shape[1]
    own = view.misfit(view.observed, view.predicted)
    seen = np.isfinite(own)
    looked_at: NDArray[np.bool_] = np.asarray(seen.any(axis=1))
    amiss = np.where(seen, own, 0.0).max(axis=1) > least
    amiss[0] = False
    if not amiss.any():
        return stayed
    for _ in range(_LOOKS):
        executed = _executed(context.q_cmd, stayed)
        sources = _before(context.q_cmd, executed, looked_at)
        fewest = np.full(len(own), np.inf)
        again, unseen_too = np.zeros_like(stayed), np.zeros(len(own), dtype=bool)
        for which in _sets(n):
            for number, before in enumerate(sources):
                commands = np.where(which, before, context.q_cmd)
                predicted = view.replay(np.where(amiss[:, None], commands, executed))
                misses = np.where(seen, view.misfit(view.observed, predicted), 0.0)
                tells = np.where(seen, view.misfit(predicted, view.predicted), 0.0).max(axis=1) > least
                left = np.where(amiss & tells & (misses.max(axis=1) < _MEETS), (misses**2).sum(axis=1), np.inf)
                better = left < fewest
                again[better], unseen_too[better] = which, bool(number)
                fewest = np.minimum(left, fewest)
        again = _with_unseen(again, unseen_too, looked_at)
        if np.array_equal(again, stayed):
            break
        stayed = again
    return stayed


def _executed(commands: Array, stayed: NDArray[np.bool_]) -> Array:
    """(N, n) commands that took effect where some of them never reached some joints."""
    executed = commands.copy()
    for row in np.flatnonzero(stayed.any(axis=1)):
        executed[row, stayed[row]] = executed[row - 1, stayed[row]]
    return executed


def _before(commands: Array, executed: Array, seen: NDArray[np.bool_]) -> list[Array]:
    """Where the arm may have stood before each row: at the last command, or where it was last seen.

    What happened at poses that nobody looked at is unknown: a run of missed poses may lead across them.
    """
    last = np.maximum.accumulate(np.where(seen, np.arange(len(seen)), 0))
    before = np.maximum(np.arange(len(seen)) - 1, 0)
    return [np.where(seen[before][:, None], executed[before], commands[before]), executed[last[before]]]


def _with_unseen(
    stayed: NDArray[np.bool_], unseen_too: NDArray[np.bool_], seen: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Return the joints that stayed with those of the poses between, which nobody looked at."""
    out = stayed.copy()
    for row in np.flatnonzero(unseen_too):
        between = row - 1
        while between > 0 and not seen[between]:
            out[between] |= stayed[row]
            between -= 1
    return out


def _all_stayed(view: View) -> list[float]:
    """Rows at which all that is seen agrees with the last executed pose."""
    rows: list[float] = []
    last = 0
    for row in range(1, len(view.observed)):
        own = view.misfit(view.observed[row], view.predicted[row])
        before = view.misfit(view.observed[row], view.predicted[last])
        # A marker that both poses put in the same place says nothing.
        telling = np.isfinite(own) & (view.misfit(view.predicted[row], view.predicted[last]) > _MISSES)
        # Of those that do tell, one that plainly misses its own pose is enough: the others meet the one before.
        if telling.any() and own[telling].max() > _MISSES and before[telling].max() < _MEETS:
            rows.append(float(row))
        else:
            last = row
    return rows


def _sets(n: int) -> list[NDArray[np.bool_]]:
    """(n,) sets of joints that may have stayed: all first, then from one joint up."""
    numbers = sorted(range(1, 2**n - 1), key=int.bit_count)
    if n > _ANY_SET:
        numbers = [number for number in numbers if number.bit_count() <= _OF_MORE]
    return [np.ones(n, dtype=bool), *(_joints_of(number, n) for number in numbers)]


def _joints_of(number: int, n: int) -> NDArray[np.bool_]:
    return np.array([bool(number >> joint & 1) for joint in range(n)])


def _packed(row: int, stayed: NDArray[np.bool_]) -> float:
    number = 0 if stayed.all() else sum(1 << joint for joint in np.flatnonzero(stayed).tolist())
    return row + number / _SETS


def _rows_and_joints(values: Array, n: int) -> list[tuple[int, NDArray[np.bool_]]]:
    """List the rows in order, each with the (n,) joints that stayed."""
    ordered = np.sort(values)
    rows = ordered.astype(int)
    sets = np.round((ordered - rows) * _SETS).astype(int)
    return [
        (row, _joints_of(number, n) if number else np.ones(n, dtype=bool))
        for row, number in zip(rows.tolist(), sets.tolist(), strict=True)
    ]


def complexity(context: Context, values: Array) -> float:
    """Of each missed pose: twice the logarithm of the rows, and of the sets of joints where not all stayed."""
    some = int((values % 1.0 > 0).sum())
    n = context.q_cmd.shape[1]
    return 2.0 * (len(values) * float(np.log(len(context))) + some * float(np.log(2**n)))


def physical(context: Context, values: Array) -> dict[str, Any]:
    """Return the missed rows as the simulated bench takes them: those of all joints, and those of each."""
    n = context.q_cmd.shape[1]
    missed = _rows_and_joints(values, n)
    parts: dict[str, Any] = {"samples": [row for row, stayed in missed if stayed.all()]}
    for joint in range(n):
        rows = [row for row, stayed in missed if stayed[joint] and not stayed.all()]
        if rows:
            parts[f"samples{joint + 1}"] = rows
    return parts


# --- how the simulated bench makes it ---


def inject(world: World, parameters: Mapping[str, Any], site: Site) -> World:
    """Lose the commands of `samples` on the wire, and those of `samplesN` on the way to servo N alone.

    A servo holds the last command that arrived.
    """
    lost = [frozenset(samples_of({"samples": parameters.get("samples", ())}))] * world.arm.n_joints
    for index in range(world.arm.n_joints):
        lost[index] = lost[index] | frozenset(samples_of({"samples": parameters.get(f"samples{index + 1}", ())}))

    def wire() -> Electronics:
        arrived = np.zeros(world.arm.n_joints)

        def receive(command: Command) -> NDArray[np.float64]:
            nonlocal arrived
            missing = np.array([command.sample in of_one for of_one in lost])
            arrived = np.where(missing, arrived, command.q)
            return arrived

        return receive

    return world.with_electronics(wire)


def _hide(rng: Generator, s: sealed.Situation) -> sealed.Hidden:
    """Draw commands that are lost: of all joints, or of a single one; apart from one another, or several in a row."""
    # Of the commands that would have moved the markers about as far as wanted, some are lost.
    count = int(rng.integers(3, max(4, round(0.04 * s.n_poses)) + 1))
    far = np.abs(np.log(np.maximum(s.steps()[1:], 1e-9) / s.target_px))
    run = int(rng.integers(2, 4)) if rng.random() < 0.25 else 1
    taken: list[int] = []
    for row in rng.permutation(1 + np.argsort(far)[: 6 * count]):
        if len(taken) < count and all(abs(row - other) > run for other in taken):
            taken.append(int(row))
    rows = sorted({row + k for row in taken for k in range(run) if row + k < s.n_poses})
    key = f"samples{int(rng.integers(1, s.arm.n_joints + 1))}" if rng.random() < 0.4 else "samples"
    return sealed.Hidden(lambda a: {key: rows}, 1.0, 1.0)


EFFECT = Effect(
    name="missed_command",
    summary="single poses at which the arm, or a joint of it, stayed where it was",
    where="arm",
    stage=Stage.COMMAND,
    term=term,
    injector=inject,
    injected=(
        Injected("samples", optional=True, kind="samples"),
        Injected("samples{joint}", optional=True, kind="samples"),
    ),
    confused_with=("outliers", "dead_band"),
    experiment="the missed poses commanded once more",
    plans=("growing_steps",),
    physical=physical,
    found=Found(find),
    complexity=complexity,
    needs_return=True,
    when_correcting="which commands will be missed cannot be known, none is reckoned with",
    sealed=sealed.Sealing(_hide),
)


def inject_in_motion(world: MotionWorld, parameters: Mapping[str, Any], site: Site) -> MotionWorld:
    """Lose the commands of the rows `samples` on the way to the drive of `joint`, which holds the one before."""
    (index,) = world.joints_at(site)
    lost = samples_of(parameters)

    def line(wires: Sequence[Wire]) -> list[Wire]:
        out = list(wires)
        wire = out[index]
        arrives = ~np.isin(wire.row, lost)
        out[index] = Wire(wire.time_s[arrives], wire.q[arrives], wire.row[arrives])
        return out

    return world.with_wiring(line)


IN_MOTION = MotionEffect(
    name=EFFECT.name,
    summary=EFFECT.summary,
    where="joint",
    confused_with=EFFECT.confused_with,
    experiment=EFFECT.experiment,
    motions=("steps",),
    injector=inject_in_motion,
    injected=(samples("samples"),),
)
