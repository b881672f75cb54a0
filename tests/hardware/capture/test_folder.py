"""Real files; a full disk is a small file system where one may be mounted."""

import json
import shutil
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from armtwin.hardware.bench.servo_map import ServoMap
from armtwin.hardware.capture.folder import CaptureFolder
from armtwin.models.arm import Arm, nominal_arm
from armtwin.models.bench import BenchDescription, Frame
from armtwin.models.camera_files import nominal_camera
from armtwin.models.errors import InputError, JobError, RecordingError
from armtwin.models.joint_limits import JointLimits
from armtwin.models.plan import Plan
from armtwin.models.recordings.reader import read_recording
from armtwin.models.recordings.writer import write_recording
from tests.support.disks import mounted

SERVOS = ServoMap(np.array([0, 1, 2]), np.full(3, 1500.0), np.array([636.62, -636.62, 636.62]))
PLAN = Plan(np.array(["a", "a", "b", "b"]), np.linspace(0.0, 0.3, 12).reshape(4, 3), np.zeros(4))


def unopened(
    folder: Path,
    plan: Plan = PLAN,
    arm: Arm | None = None,
    servos: ServoMap = SERVOS,
    hold_out: tuple[str, ...] | None = None,
) -> CaptureFolder:
    limits = JointLimits(np.full(3, -1.2), np.full(3, 1.2), 0.5)
    bench = BenchDescription(
        "hardware", arm or nominal_arm(), nominal_camera(), -80.87, limits, actuation=servos.as_table()
    )
    return CaptureFolder(folder, bench, plan, hold_out)


def begin(folder: Path, plan: Plan = PLAN, arm: Arm | None = None, servos: ServoMap = SERVOS) -> CaptureFolder:
    recording = unopened(folder, plan, arm, servos)
    recording.open()
    return recording


def frame(seed: int, time_s: float | None = None) -> Frame:
    image = np.random.default_rng(seed).integers(0, 255, (72, 128, 3), dtype=np.uint8)
    seen_s = float(seed) if time_s is None else time_s
    return Frame(image, seen_s, commanded_s=seen_s - 0.25)


def fill(folder: Path, poses: int, plan: Plan = PLAN) -> None:
    recording = begin(folder, plan)
    for seed in range(recording.done, poses):
        recording.add(frame(seed))
    recording.close()


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return tmp_path / "recording"


def test_a_check_counts_what_is_there_and_writes_nothing(folder: Path):
    unopened(folder).check()
    assert not folder.exists()

    fill(folder, 2)
    before = {path: path.stat().st_mtime_ns for path in folder.rglob("*")}
    there = unopened(folder)
    there.check()

    assert there.done == 2
    assert {path: path.stat().st_mtime_ns for path in folder.rglob("*")} == before


def test_what_a_killed_capture_left_half_written_is_cleared(folder: Path):
    fill(folder, 2)
    (folder / "frames" / ".000002.png.abc.part").write_bytes(b"\x89PNG")

    fill(folder, 4)

    assert not list(folder.rglob(".*"))
    assert len(read_recording(folder)) == 4


def test_a_capture_killed_at_its_first_file_begins_anew(folder: Path):
    folder.mkdir()
    (folder / ".recording.json.abc.part").write_text("{")

    fill(folder, 4)

    assert len(read_recording(folder)) == 4


def test_a_whole_capture_reads_back_as_a_recording(folder: Path):
    fill(folder, 4)

    recording = read_recording(folder)

    np.testing.assert_array_equal(recording.q_cmd, PLAN.q_cmd)
    assert list(recording.trajectory) == ["a", "a", "b", "b"]
    np.testing.assert_allclose(recording.time_s, [0, 1, 2, 3])
    np.testing.assert_allclose(recording.commanded_s, [-0.25, 0.75, 1.75, 2.75])
    assert sorted(recording.markers_px) == ["a", "b", "c", "f"]
    assert np.isnan(recording.markers_px["a"]).all()


def test_pictures_are_kept_bit_by_bit_under_their_sample(folder: Path):
    fill(folder, 4)

    np.testing.assert_array_equal(cv2.imread(str(folder / "frames" / "000002.png")), frame(2).image)


def test_a_finished_capture_packs_its_pictures_and_keeps_every_bit(folder: Path):
    smooth = np.broadcast_to(np.arange(1280, dtype=np.uint16) // 6, (720, 1280)).astype(np.uint8)
    picture = np.stack([smooth, smooth // 2, 255 - smooth], axis=-1)
    recording = begin(folder)
    recording.add(Frame(picture, 0.0))
    stored = recording.frame_path(0).stat().st_size
    recording.finish(())
    recording.close()

    assert recording.frame_path(0).stat().st_size < 0.5 * stored
    np.testing.assert_array_equal(cv2.imread(str(recording.frame_path(0))), picture)


def test_each_row_is_in_the_file_before_the_next_is_added(folder: Path):
    recording = begin(folder)
    for seed in range(4):
        recording.add(frame(seed))
        assert len((folder / "samples.csv").read_text().splitlines()) == seed + 2
        assert (folder / "frames" / f"{seed:06d}.png").is_file()
    recording.close()


def test_header_is_there_before_the_first_pose(folder: Path):
    begin(folder).close()

    assert json.loads((folder / "recording.json").read_text())["schema"] == "armtwin.recording/1"


def test_held_out_trajectories_are_named_when_all_rows_are_there(folder: Path):
    fill(folder, 4)
    recording = begin(folder)
    recording.finish(("b",))
    recording.close()

    assert read_recording(folder).held_out == ("b",)


def broken_off_with(folder: Path, hold_out: tuple[str, ...] | None) -> None:
    recording = unopened(folder, hold_out=hold_out)
    recording.open()
    recording.add(frame(0))
    recording.close()


@pytest.mark.parametrize("asked", [None, ("b",)], ids=["not asked again", "asked again"])
def test_what_was_to_be_held_out_is_held_out_by_the_capture_that_goes_on(folder: Path, asked: tuple[str, ...] | None):
    broken_off_with(folder, ("b",))

    recording = unopened(folder, hold_out=asked)
    recording.open()
    for seed in range(1, 4):
        recording.add(frame(seed))
    recording.finish()
    recording.close()

    assert read_recording(folder).held_out == ("b",)


def test_another_hold_out_than_the_capture_began_with_is_refused(folder: Path):
    broken_off_with(folder, ("b",))

    with pytest.raises(InputError, match=r"--hold-out: a is asked for, the capture in .* began with b; leave it out"):
        unopened(folder, hold_out=("a",)).check()


def test_a_hold_out_that_is_asked_for_later_is_kept_over_another_break(folder: Path):
    broken_off_with(folder, None)
    later = unopened(folder, hold_out=("b",))
    later.open()
    later.close()

    fill(folder, 4)
    last = unopened(folder)
    last.open()
    last.finish()
    last.close()

    assert read_recording(folder).held_out == ("b",)


def test_a_capture_that_broke_off_is_taken_up_behind_its_last_pose(folder: Path):
    fill(folder, 2)
    before = (folder / "samples.csv").read_text()

    recording = begin(folder)
    assert recording.done == 2
    recording.close()
    fill(folder, 4)

    assert (folder / "samples.csv").read_text().startswith(before)
    assert list(read_recording(folder).sample) == [0, 1, 2, 3]


def test_time_does_not_run_backwards_when_taken_up(folder: Path):
    fill(folder, 2)
    recording = begin(folder)
    recording.add(frame(2, time_s=0.5))
    recording.add(frame(3, time_s=0.9))
    recording.close()

    taken_up = read_recording(folder)
    assert (np.diff(taken_up.time_s) > 0).all()
    np.testing.assert_allclose(taken_up.time_s - taken_up.commanded_s, 0.25, atol=1e-6)


def test_a_row_torn_by_a_power_cut_is_done_again(folder: Path):
    fill(folder, 3)
    content = (folder / "samples.csv").read_bytes()
    (folder / "samples.csv").write_bytes(content[:-7])

    fill(folder, 4)

    assert list(read_recording(folder).sample) == [0, 1, 2, 3]


@pytest.mark.parametrize("lost", [1, 3])
def test_last_rows_whose_pictures_a_power_cut_took_are_done_again(folder: Path, lost: int):
    fill(folder, 3)
    for sample in range(3 - lost, 3):
        (folder / "frames" / f"{sample:06d}.png").unlink()

    taken_up = begin(folder)
    assert taken_up.done == 3 - lost
    taken_up.close()
    fill(folder, 4)

    assert list(read_recording(folder).sample) == [0, 1, 2, 3]
    assert all((folder / "frames" / f"{sample:06d}.png").is_file() for sample in range(4))


def test_a_measured_row_without_its_picture_is_not_dropped(folder: Path):
    fill(folder, 2)
    recording = read_recording(folder)
    markers = {name: np.full((2, 2), 100.0) for name in recording.markers_px}
    write_recording(folder, replace(recording, markers_px=markers))
    (folder / "frames" / "000001.png").unlink()

    with pytest.raises(RecordingError, match=r"frames/000001.png is missing"):
        begin(folder)


@pytest.mark.parametrize("time_s", ["abc", "nan", "inf", "1.0.0"])
def test_a_time_that_is_none_is_refused_by_its_line(folder: Path, time_s: str):
    fill(folder, 2)
    samples = folder / "samples.csv"
    lines = samples.read_text().splitlines(keepends=True)
    cells = lines[-1].split(",")
    samples.write_text("".join(lines[:-1]) + ",".join([cells[0], time_s, *cells[2:]]))

    with pytest.raises(RecordingError, match=rf"samples.csv: line 3: time_s is '{time_s}', a finite number .* wanted"):
        begin(folder)


def other_zero() -> ServoMap:
    return replace(SERVOS, zero_us=np.array([1500.0, 1344.0, 1500.0]))


def test_what_another_servo_map_captured_is_not_gone_on_with(folder: Path):
    fill(folder, 2)

    with pytest.raises(
        RecordingError, match=r"another servo map .*\(actuation.joint 2.zero_us: 1500.0 there, 1344.0 here\); choose"
    ):
        begin(folder, servos=other_zero())

    assert begin(folder).done == 2


def test_a_servo_map_that_no_pose_was_captured_with_may_still_be_mended(folder: Path):
    begin(folder).close()
    mended = begin(folder, servos=other_zero())
    mended.add(frame(0))
    mended.close()

    assert begin(folder, servos=other_zero()).done == 1


def test_poses_that_came_without_a_servo_map_are_gone_on_with(folder: Path):
    fill(folder, 2)
    (folder / "bench.json").unlink()

    recording = begin(folder)
    assert recording.done == 2
    recording.close()


def test_a_recording_that_is_taken_up_goes_on_with_its_first_clock(folder: Path):
    recording = unopened(folder)
    recording.open(clock_origin_s=1000.0)
    recording.add(frame(0, time_s=2.0))
    recording.close()

    again = unopened(folder)
    again.open(clock_origin_s=1060.0)
    again.add(frame(1, time_s=3.0))
    again.close()

    np.testing.assert_allclose(read_recording(folder).time_s, [2.0, 63.0])


def test_two_captures_into_one_folder_are_refused(folder: Path):
    first = begin(folder)
    for second in (unopened(folder).check, unopened(folder).open):
        with pytest.raises(InputError, match="another armtwin is at work there"):
            second()
    first.close()

    unopened(folder).check()


def test_a_picture_of_which_nothing_reached_the_disk_is_taken_again(folder: Path):
    fill(folder, 2)
    (folder / "frames" / "000001.png").write_bytes(b"")

    recording = begin(folder)
    assert recording.done == 1
    recording.close()


def test_a_file_in_the_place_of_the_pictures_folder_is_refused(folder: Path):
    fill(folder, 0)
    (folder / "frames").rmdir()
    (folder / "frames").write_text("")

    with pytest.raises(RecordingError, match="frames: is a file"):
        unopened(folder).check()


def test_another_arms_data_is_refused_and_left_alone(folder: Path):
    fill(folder, 2)
    before = (folder / "samples.csv").read_bytes()
    longer = replace(nominal_arm(), link_lengths_mm=np.array([121.0, 121.7, 38.0, 6.73]))

    with pytest.raises(
        RecordingError, match=r"holds another arm's data \(arm.link_lengths_mm: \[120.0, .* choose another"
    ):
        begin(folder, arm=longer)

    assert (folder / "samples.csv").read_bytes() == before


def test_another_plans_poses_are_refused(folder: Path):
    fill(folder, 2)
    other = Plan(PLAN.trajectory, PLAN.q_cmd + 0.01, PLAN.payload_kg)

    with pytest.raises(RecordingError, match=r"samples.csv: line 2: holds pose 'a,0.0,.*' of another plan"):
        begin(folder, other)


def test_a_recording_longer_than_the_plan_is_refused(folder: Path):
    fill(folder, 4)
    shorter = Plan(PLAN.trajectory[:2], PLAN.q_cmd[:2], PLAN.payload_kg[:2])

    with pytest.raises(RecordingError, match="the plan has 2 poses only"):
        begin(folder, shorter)


def test_a_missing_picture_is_named(folder: Path):
    fill(folder, 2)
    (folder / "frames" / "000000.png").unlink()

    with pytest.raises(RecordingError, match=r"frames/000000.png is missing"):
        begin(folder)


def test_a_folder_of_something_else_is_refused(folder: Path):
    folder.mkdir()
    (folder / "thesis.tex").write_text("precious")

    with pytest.raises(InputError, match=r"not empty and no recording \(found thesis.tex\)"):
        begin(folder)


@pytest.mark.parametrize("content", ["{", "[]", '{"schema": "armtwin.recording/2"}'])
def test_a_broken_header_is_refused_in_one_line(folder: Path, content: str):
    folder.mkdir()
    (folder / "recording.json").write_text(content)

    with pytest.raises(RecordingError) as caught:
        begin(folder)

    assert "\n" not in str(caught.value)


def test_payload_is_a_column_where_the_plan_hangs_one(folder: Path):
    fill(folder, 4, Plan(PLAN.trajectory, PLAN.q_cmd, np.array([0.0, 0.0, 0.05, 0.05])))

    recorded = read_recording(folder).payload_kg

    assert recorded is not None
    np.testing.assert_array_equal(recorded, [0.0, 0.0, 0.05, 0.05])


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    with mounted(tmp_path, 12) as disk:
        yield disk


def test_too_small_a_disk_is_refused_before_anything_is_written(small_disk: Path):
    long = Plan(np.full(40, "a"), np.zeros((40, 3)), np.zeros(40))

    with pytest.raises(InputError, match=r"40 pictures may need 111 MB, the disk has 13 MB free"):
        begin(small_disk / "recording", long)

    assert not (small_disk / "recording").exists()


def test_a_disk_that_fills_up_leaves_a_whole_recording_that_can_be_taken_up(small_disk: Path):
    recording = begin(small_disk / "recording")
    recording.add(frame(0))
    (small_disk / "film").write_bytes(bytes(12 << 20)[: _free(small_disk)])

    with pytest.raises(JobError, match=r"No space left on device.*1 of 4 poses are kept"):
        recording.add(frame(1))
    recording.close()

    assert list(read_recording(small_disk / "recording").sample) == [0]
    (small_disk / "film").unlink()
    fill(small_disk / "recording", 4)
    assert list(read_recording(small_disk / "recording").sample) == [0, 1, 2, 3]


def _free(mount: Path) -> int:
    return shutil.disk_usage(mount).free
