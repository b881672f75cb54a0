import csv
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from armtwin.models.arm import Arm, nominal_arm
from armtwin.models.recordings.reader import read_recording
from armtwin.models.recordings.recording import Recording
from armtwin.models.recordings.writer import columns_of, row_of, samples_csv, write_recording

finite = st.floats(-6.0, 6.0)
pixel = st.floats(0.0, 5000.0)


def assert_same(one: Recording, other: Recording) -> None:
    """Every number of both to the last bit."""
    assert one.arm.name == other.arm.name
    for name in ("link_lengths_mm", "gravity_m_s2", "link_masses_kg"):
        np.testing.assert_array_equal(getattr(one.arm, name), getattr(other.arm, name))
    assert one.arm.tip_mass_kg == other.arm.tip_mass_kg
    for name in ("arm_plane_z_mm", "pixel_noise_px", "held_out"):
        assert getattr(one, name) == getattr(other, name)
    for name in ("sample", "time_s", "trajectory", "q_cmd", "q_meas", "commanded_s", "payload_kg", "temperature_c"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    assert list(one.markers_px) == list(other.markers_px)
    for name, pixels in one.markers_px.items():
        np.testing.assert_array_equal(pixels, other.markers_px[name])
    assert (one.camera is None) == (other.camera is None)
    if one.camera is not None and other.camera is not None:
        assert one.camera.lens.named == other.camera.lens.named
        for name in ("K", "R_board_camera", "t_board_camera_mm"):
            np.testing.assert_array_equal(getattr(one.camera, name), getattr(other.camera, name))


def test_a_recording_reads_back_to_the_last_bit(recording, tmp_path):
    write_recording(tmp_path, recording)
    again = read_recording(tmp_path)
    assert_same(again, recording)
    assert again.folder == tmp_path
    assert not again.has_time


def test_measured_angles_payload_and_temperature_read_back(recording, tmp_path):
    rng = np.random.default_rng(1)
    q_meas = rng.uniform(-1, 1, (6, 3))
    q_meas[3, 1] = np.nan
    whole = replace(recording, q_meas=q_meas, payload_kg=rng.random(6), temperature_c=np.array([20.0] * 5 + [np.nan]))
    write_recording(tmp_path, whole)
    assert_same(read_recording(tmp_path), whole)


def test_the_times_of_commands_read_back(recording, tmp_path):
    timed = replace(recording, time_s=0.7 * np.arange(1, 7), commanded_s=np.array([0.0, 0.7, np.nan, 2.1, 2.8, 3.5]))
    write_recording(tmp_path, timed)
    assert_same(read_recording(tmp_path), timed)


def test_a_recording_of_angles_alone_has_no_camera(tmp_path):
    alone = Recording(
        arm=Arm("protractor", np.array([80.0]), np.zeros(2)),
        sample=np.array([5, 7]),
        time_s=np.full(2, np.nan),
        trajectory=np.array(["up", "up"]),
        q_cmd=np.array([[0.1], [0.2]]),
        q_meas=np.array([[0.12], [0.23]]),
    )
    write_recording(tmp_path, alone)
    assert "camera" not in json.loads((tmp_path / "recording.json").read_text())
    assert_same(read_recording(tmp_path), alone)


@given(
    q=arrays(float, (4, 3), elements=finite),
    pixels=arrays(float, (4, 2), elements=pixel),
    times=st.lists(st.one_of(st.floats(0, 1e6), st.just(float("nan"))), min_size=4, max_size=4),
    names=st.lists(st.text("abc ,\"'é-", min_size=1, max_size=8), min_size=4, max_size=4),
    unseen=arrays(bool, 4),
)
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=60, deadline=None)
def test_any_recording_reads_back_to_the_last_bit(tmp_path, recording, q, pixels, times, names, unseen):
    known = [t for t in times if t == t]
    ordered = iter(sorted(known))
    made = Recording(
        arm=nominal_arm(),
        camera=recording.camera,
        arm_plane_z_mm=-80.87,
        sample=np.array([3, 1, 2, 0]),
        time_s=np.array([next(ordered) if t == t else np.nan for t in times]),
        trajectory=np.array(names),
        q_cmd=q,
        markers_px={"c": np.where(unseen[:, None], np.nan, pixels)},
    )
    write_recording(tmp_path, made)
    assert_same(read_recording(tmp_path), made)


def test_every_column_carries_its_unit_in_the_contracts_order(recording):
    assert columns_of(recording) == [
        "sample", "time_s", "trajectory", "theta1_cmd_rad", "theta2_cmd_rad", "theta3_cmd_rad",
        "a_u_px", "a_v_px", "f_u_px", "f_v_px",
    ]  # fmt: skip


def test_an_unseen_marker_is_an_empty_cell(recording):
    row = dict(zip(columns_of(recording), row_of(recording, 2), strict=True))
    assert row["f_u_px"] == row["f_v_px"] == row["time_s"] == ""
    assert row["a_u_px"] != ""


def test_the_table_is_a_plain_csv_with_one_row_a_pose(recording):
    lines = list(csv.DictReader(samples_csv(recording).splitlines()))
    assert [line["sample"] for line in lines] == ["0", "1", "2", "3", "4", "5"]


def test_writing_twice_gives_the_same_bytes_and_leaves_frames_alone(recording, tmp_path):
    (tmp_path / "frames").mkdir()
    (tmp_path / "frames" / "000000.png").write_bytes(b"picture")
    write_recording(tmp_path, recording)
    first = (tmp_path / "samples.csv").read_bytes()
    write_recording(tmp_path, recording)
    assert (tmp_path / "samples.csv").read_bytes() == first
    assert sorted(p.name for p in tmp_path.iterdir()) == ["frames", "recording.json", "samples.csv"]
    assert (tmp_path / "frames" / "000000.png").read_bytes() == b"picture"


def test_the_frame_of_a_row_is_named_by_its_sample(recording, tmp_path):
    numbered = replace(recording, sample=np.arange(6) + 40, folder=tmp_path)
    assert numbered.frame_path(2) == tmp_path / "frames" / "000042.png"
    assert recording.frame_path(0) is None


DATA = Path(__file__).resolve().parents[3].parent / "shared" / "data" / "brachiograph"


@pytest.mark.skipif(not DATA.is_dir(), reason="the BrachioGraph measurements are not beside the repository")
@pytest.mark.parametrize("joint", ["shoulder", "elbow"])
def test_real_recordings_read_back(joint, tmp_path):
    measured = read_recording(DATA / joint)
    write_recording(tmp_path, measured)
    assert_same(read_recording(tmp_path), measured)
