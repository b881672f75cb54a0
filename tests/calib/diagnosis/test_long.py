"""Long recordings: a fair part is searched, and what it showed is fitted to all poses."""

from __future__ import annotations

import time

import numpy as np
import pytest

from armtwin.calib.diagnosis.diagnosis import Diagnosis, diagnose
from armtwin.models.arm import Arm
from armtwin.models.recordings.recording import Recording, make_samples

NOISE_RAD = 0.002


def wandering(n: int, *, play_rad: float = 0.0, slip_at: int | None = None, seed: int = 0) -> Recording:
    """Return an arm of two joints that wanders for n poses, with play at joint 2 or a slip of joint 1."""
    rng = np.random.default_rng(seed)
    q = 0.8 * np.sin(np.cumsum(rng.normal(0.0, 0.15, (n, 2)), axis=0))
    seen, at = q.copy(), q[0, 1]
    for row in range(n):
        at = min(max(at, q[row, 1] - play_rad / 2.0), q[row, 1] + play_rad / 2.0)
        seen[row, 1] = at
    if slip_at is not None:
        seen[slip_at:, 0] += 0.03
    return Recording(
        arm=Arm("two", np.array([100.0, 80.0]), np.zeros(2)),
        sample=make_samples(n),
        time_s=2.0 * np.arange(n),
        trajectory=np.full(n, "walk"),
        q_cmd=q,
        q_meas=seen + 0.02 + rng.normal(0.0, NOISE_RAD, seen.shape),
    )


def named(found: Diagnosis) -> set[str]:
    return {cause.active.effect.name for cause in found.causes}


def test_of_many_poses_a_part_shows_the_cause_and_all_of_them_say_how_large_it_is() -> None:
    found = diagnose(wandering(3_000, play_rad=0.03))
    assert named(found) == {"backlash"}
    assert found.explanation.data.n_values > 4_000
    (cause,) = found.causes
    assert cause.active.values[0] == pytest.approx(0.03, abs=4.0 * cause.std[0])


def test_what_happened_at_one_sample_is_found_to_the_sample() -> None:
    found = diagnose(wandering(3_000, slip_at=1_777))
    assert named(found) == {"joint_slip"}
    assert abs(found.causes[0].active.values[1] - 1_777) <= 1


def test_of_a_long_recording_without_a_fault_nothing_is_named() -> None:
    assert diagnose(wandering(3_000)).verdict == "none"


def test_of_very_many_poses_no_more_are_looked_at_than_time_allows() -> None:
    started = time.process_time()
    found = diagnose(wandering(60_000, play_rad=0.03))
    assert named(found) == {"backlash"}
    assert len(found.problem.context) < 10_000
    assert time.process_time() - started < 60.0
