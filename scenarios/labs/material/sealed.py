"""Lab 7: robots to practise on, and the way to the one that is served for you."""

from __future__ import annotations

import io
import tempfile
import zipfile
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from armtwin.models.arm import nominal_arm
from armtwin.models.errors import InputError, JobError
from armtwin.models.joint_limits import JointLimits
from armtwin.models.plan import plan_of
from armtwin.models.recordings.reader import read_recording
from armtwin.models.recordings.recording import Recording
from armtwin.scenarios.benches.door import open_bench
from armtwin.scenarios.benches.spec import RemoteSpec
from armtwin.sim.observe import make_recording
from armtwin.sim.physics.simulation import default_clock
from armtwin.sim.sealed import Sealed, draw_world

Array = NDArray[np.float64]

BUDGET = 60
NOISE_PX = 0.06
PRACTICE = ("backlash", "dead_band", "gravity_sag", "servo_gain", "servo_nonlinearity")
LIMITS = JointLimits(np.full(3, -np.pi / 2), np.full(3, np.pi / 2), np.pi)


def measure(robot: int, q_cmd: Array) -> Recording:
    """Return what a practice robot's camera sees at (N, 3) commands, rad; the last sixth is held out.

    Raises `InputError` for more poses than the budget, or beyond the joint limits.
    """
    q = np.asarray(q_cmd, dtype=float)
    check_poses(q)
    world = practice_robot(robot).world
    kept = len(q) - max(2, len(q) // 6)
    plan = plan_of({"mine": q[:kept], "held_out": q[kept:]})
    clock = default_clock(len(plan), world.pose_period_s)
    rng = np.random.default_rng(robot)
    return make_recording(world, plan.q_cmd, plan.trajectory, clock, rng, NOISE_PX, held_out=("held_out",))


def check_poses(q: Array) -> None:
    """Raise `InputError` unless (N, 3) poses fit budget and limits."""
    if q.ndim != 2 or q.shape[1] != 3:
        raise InputError(f"an array (N, 3) of commands is wanted, yours has shape {q.shape}")
    if not 12 <= len(q) <= BUDGET:
        raise InputError(f"12 to {BUDGET} poses are wanted, yours are {len(q)}")
    for row, one in enumerate(q):
        LIMITS.check_pose(one, f"pose {row}")


@cache
def practice_robot(robot: int) -> Sealed:
    """Return a practice robot, 1 to 20, with the truth about it."""
    rng = np.random.default_rng([7, robot])
    effect = PRACTICE[int(rng.integers(len(PRACTICE)))]
    markers = nominal_arm().marker_names
    return draw_world(rng, effect, "strong", n_poses=BUDGET, noise_px=NOISE_PX, markers=markers, missing=0.0)


def measure_served(address: str, token: str, q_cmd: Array) -> Recording:
    """Run (N, 3) commands on the robot that is served for you, and return all that it has shown you so far.

    Raises `InputError` where address, token or a pose is wrong, `JobError` where the budget is spent.
    """
    with open_bench(RemoteSpec(address, token)) as bench:
        for q in np.asarray(q_cmd, dtype=float):
            bench.move(q)
            bench.capture()
    packed = _ask("GET", address, token, "api/recording.zip").content
    with tempfile.TemporaryDirectory() as folder, zipfile.ZipFile(io.BytesIO(packed)) as archive:
        archive.extractall(folder)
        return read_recording(next(Path(folder).iterdir()))


def hand_in(address: str, token: str, answer: dict[str, Any], line_q_cmd_rad: Array | None = None) -> str:
    """Hand in an answer, the last of which counts; return what the server says."""
    line = None if line_q_cmd_rad is None else np.asarray(line_q_cmd_rad, dtype=float).tolist()
    said = _ask("POST", address, token, "api/answer", {**answer, "line_q_cmd_rad": line}).json()
    return f"answer number {said['answers']} is handed in"


def _ask(method: str, address: str, token: str, path: str, body: dict[str, Any] | None = None) -> Any:
    import httpx  # the extra `serve`

    url = f"{address.split('?')[0].rstrip('/')}/{path}"
    headers = {"Authorization": f"Bearer {token}"}
    try:
        answer = httpx.request(method, url, headers=headers, json=body, timeout=60, trust_env=False)
    except httpx.HTTPError as error:
        raise JobError(f"{url}: {type(error).__name__}; try armtwin serve --check {address}") from None
    if not answer.is_success:
        raise InputError(f"{url}: {answer.text[:300]}")
    return answer
