"""What a visitor does with a served bench, without the server."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from armtwin.models.errors import InputError, JobError
from armtwin.models.recordings.reader import read_recording
from armtwin.scenarios.scenario import EffectTable
from armtwin.scenarios.serving.live_bench import LiveBench
from armtwin.scenarios.serving.sources import source_of
from tests.support.disks import grow, mounted

PLAY = EffectTable(name="backlash", joint=2, parameters={"width_rad": 0.05})
SOURCE = source_of("simulated")
POSES = SOURCE.plans["circle_25"].q_cmd


@pytest.fixture
def live(tmp_path: Path) -> Iterator[LiveBench]:
    bench = LiveBench(SOURCE, tmp_path)
    bench.connect()
    yield bench
    bench.shut_down()


def test_a_fault_that_is_put_in_shows_between_twin_and_picture_and_goes_when_it_is_taken_out(live: LiveBench) -> None:
    def worst_mm() -> float:
        live.approach(POSES[12])
        live.approach(POSES[0])
        drawn = SOURCE.description
        miss = live.capture().miss("drawing", drawn.arm, drawn.camera, drawn.arm_plane_z_mm)
        assert miss.worst_mm is not None
        return miss.worst_mm

    assert worst_mm() < 0.1
    live.put_faults([PLAY])
    assert worst_mm() > 1.0
    live.put_faults([])
    assert worst_mm() < 0.1


def test_a_fault_that_cannot_be_built_leaves_the_bench_as_it_was(live: LiveBench) -> None:
    live.move(POSES[0])
    with pytest.raises(InputError, match="joint"):
        live.put_faults([replace_joint(PLAY, 9)])
    assert live.faults == ()
    assert live.connected


def _is_kept(live: LiveBench, number: int) -> bool:
    live.run(SOURCE.plans["line"], number)
    try:
        live.recording_folder()
    except JobError as error:
        assert "No space left" in str(error)  # noqa: PT017
        return False
    return True


def replace_joint(fault: EffectTable, joint: int) -> EffectTable:
    return fault.model_copy(update={"joint": joint})


def test_a_bench_that_is_no_simulation_takes_no_faults(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="only a simulated bench"):
        LiveBench(replace(SOURCE, takes_faults=False), tmp_path).put_faults([PLAY])


def test_what_is_kept_is_a_recording_that_every_command_reads(live: LiveBench) -> None:
    for number in range(3):
        live.run(SOURCE.plans["line"], number)
    recording = read_recording(live.recording_folder())
    assert list(recording.trajectory) == ["line"] * 3
    np.testing.assert_array_equal(recording.q_cmd, SOURCE.plans["line"].q_cmd[:3])
    assert np.isfinite(np.stack(list(recording.markers_px.values()))).all()
    assert recording.frame_path(2).is_file()  # type: ignore[union-attr]
    assert len(live.misses) == 3


def test_a_new_recording_is_empty_and_the_last_one_stays(live: LiveBench) -> None:
    live.run(SOURCE.plans["line"], 0)
    first = live.recording_folder()
    live.begin_recording()
    with pytest.raises(JobError, match="nothing is recorded"):
        live.recording_folder()
    live.run(SOURCE.plans["line"], 1)
    assert live.recording_folder() != first
    assert len(read_recording(first)) == 1


def test_a_pose_that_a_full_disk_does_not_take_is_told_and_the_rest_is_a_whole_recording(tmp_path: Path) -> None:
    with mounted(tmp_path, 1) as mount:
        live = LiveBench(SOURCE, mount)
        live.connect()
        kept = [number for number in range(8) if _is_kept(live, number)]
        assert len(kept) < 8
        grow(mount, 40)
        for number in (20, 21):
            assert _is_kept(live, number)
        recording = read_recording(live.recording_folder())
        assert recording.sample.tolist() == list(range(len(kept) + 2))
        np.testing.assert_array_equal(recording.q_cmd, SOURCE.plans["line"].q_cmd[[*kept, 20, 21]])
        assert len(live.misses) == len(recording)
        live.shut_down()
