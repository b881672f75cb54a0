"""Experiments on a bench with a camera: what is recorded goes on behind what was, on the same bench alone."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from armtwin.models.errors import InputError
from armtwin.models.plan import Plan
from armtwin.models.recordings.reader import read_recording
from armtwin.models.recordings.recording import Recording
from armtwin.scenarios.benches.experiments import check_same_bench, followed_by, recorded_on
from armtwin.scenarios.closed_loop import close_loop, on_bench
from armtwin.sim.bench import SimulatedBench
from tests.support.recordings import recording
from tests.support.worlds import flat_world, scattered, small_camera, upright_world, with_effect


def timed(offset_s: float = 0.0) -> Recording:
    one = recording()
    seen = offset_s + 2.0 * np.arange(1, len(one) + 1)
    return replace(one, time_s=seen, commanded_s=seen - 1.5)


def test_rows_go_on_behind_the_others_with_their_own_numbers_and_one_clock() -> None:
    first, more = timed(100.0), timed()
    n = len(first)
    both = followed_by(first, more)
    assert len(both) == 2 * n
    assert len(set(both.sample)) == 2 * n
    np.testing.assert_allclose(np.diff(both.time_s[n:]), 2.0)
    assert both.commanded_s is not None
    assert (both.commanded_s[n:] >= both.time_s[n - 1]).all()
    np.testing.assert_allclose(both.time_s[n:] - both.commanded_s[n:], 1.5)
    np.testing.assert_array_equal(both.markers_px["f"][n:], more.markers_px["f"])


def test_a_recording_without_times_stays_without() -> None:
    timeless = replace(recording(), time_s=np.full(len(recording()), np.nan))
    both = followed_by(timeless, timed())
    assert not both.has_time
    assert both.commanded_s is None


@pytest.mark.parametrize("key", ["arm", "camera", "arm_plane_z_mm"])
def test_a_recording_of_another_bench_is_refused_by_what_differs(key: str) -> None:
    bench = SimulatedBench(flat_world())
    what = bench.description
    own = replace(recording(), arm=what.arm, camera=what.camera, arm_plane_z_mm=what.arm_plane_z_mm)
    check_same_bench(bench, own)
    other = {
        "arm": replace(what.arm, gravity_m_s2=np.array([0.0, -9.81])),
        "camera": replace(what.camera, image_width=1281),
        "arm_plane_z_mm": -81.0,
    }[key]
    with pytest.raises(InputError, match=f"key '{key}' is another one than the bench's"):
        check_same_bench(bench, replace(own, **{key: other}))  # type: ignore[arg-type]


@pytest.mark.slow
def test_the_loop_is_closed_on_a_bench_that_is_watched(tmp_path: Path) -> None:
    world = with_effect(small_camera(upright_world()), "backlash", {"width_rad": 0.03}, joint=2)
    poses = scattered(40, 1)
    with SimulatedBench(world, seed=1, shadows=False) as bench:
        first = recorded_on(bench, Plan(np.repeat(["a", "b"], 20), poses, np.zeros(40)), tmp_path / "first")
        rounds = close_loop(on_bench(bench, tmp_path), replace(first, held_out=("b",)), most_rounds=2)
    assert rounds[0].experiment is not None
    assert len(rounds) == 2
    kept = read_recording(tmp_path / "round-1", unmeasured=True)
    assert len(rounds[1].recording) == len(first) + len(kept)
    assert (np.diff(rounds[1].recording.time_s) > 0).all()
