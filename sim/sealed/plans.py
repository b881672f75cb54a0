"""Plans that a bench might run: blocks of poses of several styles, in joint or in Cartesian space."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from armtwin.models.arm import Arm
from armtwin.models.errors import UnreachablePoseError
from armtwin.models.kinematics import inverse
from armtwin.models.plan import Plan, plan_of
from armtwin.models.trajectories import circle, line

Array = NDArray[np.float64]

# The tip's part of the picture that the nominal webcam sees with the arm's base at its lower edge.
_X_MM = (-185.0, -75.0)
_Y_MM = (0.0, 95.0)
_THETA_RAD = (np.pi - 0.7, np.pi + 0.7)
# Joint ranges of the paper's arm within which all markers stay in the picture.
_PAPER_RANGE_RAD = np.array([[-0.45, 0.35], [-0.35, 0.45], [-0.8, 0.8]])
_RANGE_RAD = (-0.7, 0.7)

Block = Callable[[Generator, Arm, int], Array]


def draw_plan(rng: Generator, arm: Arm, n_poses: int) -> tuple[Plan, tuple[str, ...]]:
    """Draw a plan of about `n_poses` and the names of its held-out trajectories.

    It always has scattered poses, joints swept there and back, and paths followed in fine steps, in random order and
    shares; two blocks of different kinds are held out. The first block is never held out.
    """
    kinds = list(_PAPER_BLOCKS if arm.form.zero_is_drawn else _CHAIN_BLOCKS)
    names = [*kinds, *rng.choice(kinds, size=3)]
    shares = rng.dirichlet(np.full(len(names), 8.0))
    order = rng.permutation(len(names))
    blocks: dict[str, Array] = {}
    of_kind: dict[str, list[str]] = {kind: [] for kind in kinds}
    for index in order:
        kind = names[index]
        name = f"{kind}_{len(of_kind[kind]) + 1}"
        of_kind[kind].append(name)
        build = (_PAPER_BLOCKS if arm.form.zero_is_drawn else _CHAIN_BLOCKS)[kind]
        blocks[name] = build(rng, arm, max(6, round(shares[index] * n_poses)))
    first = next(iter(blocks))
    # Kinds of which another block remains to be fitted come first.
    last = sorted((of_kind[kind] for kind in kinds if of_kind[kind][-1] != first), key=len, reverse=True)
    return plan_of(blocks), tuple(of_one[-1] for of_one in last[:2])


def _scattered(rng: Generator, arm: Arm, n: int) -> Array:
    """Poses all over the joints' ranges."""
    low, high = _ranges(arm).T
    return rng.uniform(low, high, (n, arm.n_joints))


def _sweep(rng: Generator, arm: Arm, n: int) -> Array:
    """Each joint alone there and back over much of its range, in even steps, the others resting somewhere."""
    low, high = _ranges(arm).T
    rest = rng.uniform(0.7 * low, 0.7 * high)
    q = np.tile(rest, (n, 1))
    for joint, rows in enumerate(np.array_split(np.arange(n), arm.n_joints)):
        span = np.sort(rng.uniform(low[joint], high[joint], 2))
        span = np.where(np.ptp(span) < 0.3, [low[joint], high[joint]], span)
        up = (len(rows) + 1) // 2
        there = np.linspace(span[0], span[1], up)
        q[rows, joint] = np.concatenate([there, there[::-1]])[: len(rows)]
    return q


def _wave(rng: Generator, arm: Arm, n: int) -> Array:
    """All joints at once along sines of different frequency: a smooth path with many reversals."""
    low, high = _ranges(arm).T
    cycles = rng.uniform(0.7, 2.5, arm.n_joints)
    phase = rng.uniform(-np.pi, np.pi, arm.n_joints)
    turn = np.linspace(0.0, 2 * np.pi, n)[:, None]
    return 0.5 * (low + high) + 0.45 * (high - low) * np.sin(cycles * turn + phase)


def _circle(rng: Generator, arm: Arm, n: int) -> Array:
    """A circle about the paper's centre, of a radius like the paper's, either way round."""
    poses = circle((-130.0, 40.0), float(rng.uniform(12.0, 30.0)), n, float(rng.uniform(*_THETA_RAD)))
    return _reach(arm, poses[::-1] if rng.random() < 0.5 else poses)


def _line_and_back(rng: Generator, arm: Arm, n: int) -> Array:
    """A straight line there and back, as the paper's validation line."""
    while True:
        ends = np.stack([rng.uniform(*_X_MM, 2), rng.uniform(*_Y_MM, 2)], axis=-1)
        if np.hypot(*(ends[1] - ends[0])) > 30.0:
            break
    (x0, y0), (x1, y1) = ends
    there = line((x0, y0), (x1, y1), (n + 1) // 2, float(rng.uniform(*_THETA_RAD)))
    return _reach(arm, np.concatenate([there, there[::-1]])[:n])


def _grid(rng: Generator, arm: Arm, n: int) -> Array:
    """A grid over the tip's part of the picture, row by row, with the tip turned a little more each row."""
    rows = max(2, round(np.sqrt(n)))
    columns = -(-n // rows)
    x = np.linspace(*_X_MM, columns)
    turns = _THETA_RAD if rng.random() < 0.5 else _THETA_RAD[::-1]
    poses = [
        (column, y, theta)
        for k, (y, theta) in enumerate(zip(np.linspace(*_Y_MM, rows), np.linspace(*turns, rows), strict=True))
        for column in (x[::-1] if k % 2 else x)
    ]
    return _reach(arm, np.array(poses[:n]))


def joint_ranges(arm: Arm) -> Array:
    """(n, 2) lowest and highest angle of each joint, rad: the drawing's, or what the nominal webcam sees."""
    if arm.joint_limits_rad is not None:
        return arm.joint_limits_rad
    return _ranges(arm)


def _ranges(arm: Arm) -> Array:
    """(n, 2) joint ranges from which plans are drawn."""
    return _PAPER_RANGE_RAD if arm.form.zero_is_drawn else np.tile(_RANGE_RAD, (arm.n_joints, 1))


def _reach(arm: Arm, poses: Array) -> Array:
    """Commands for the poses that are within reach."""
    reached = []
    for pose in poses:
        try:
            reached.append(inverse(arm, pose[None])[0])
        except UnreachablePoseError:
            continue
    return np.array(reached)


_CHAIN_BLOCKS: dict[str, Block] = {"scattered": _scattered, "sweep": _sweep, "wave": _wave}
_PAPER_BLOCKS: dict[str, Block] = {
    **_CHAIN_BLOCKS,
    "circle": _circle,
    "line": _line_and_back,
    "grid": _grid,
}
