"""Recordings measured from their frames, and frames that cannot be."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from armtwin.calib.markers import measure_frames, measure_recording
from armtwin.models.arm import nominal_arm
from armtwin.models.camera import Camera, project
from armtwin.models.coordinate_frames import robot_to_board
from armtwin.models.errors import RecordingError
from armtwin.models.kinematics import marker_positions
from armtwin.models.recordings.recording import Recording, make_samples
from tests.support.discs import PLANE_MM, draw_discs, take

BASE_MM = np.array([40.0, -33.0, PLANE_MM])
POSES = np.array([[0.0, 0.0, 0.3], [0.05, 0.05, 0.2], [0.1, 0.1, 0.1]])


@pytest.fixture(scope="module")
def frames(webcam: Camera) -> list[np.ndarray]:
    """Three poses; in the second one B is hidden."""
    rng = np.random.default_rng(11)
    pictures = []
    for row, q in enumerate(POSES):
        places = robot_to_board(marker_positions(nominal_arm(), q[None])[0], BASE_MM)[:, :2]
        pictures.append(take(draw_discs(webcam, np.delete(places, 1, axis=0) if row == 1 else places, 7.0), 2.0, rng))
    return pictures


@pytest.fixture
def recording(tmp_path: Path, webcam: Camera, frames: list[np.ndarray]) -> Recording:
    (tmp_path / "frames").mkdir()
    for row, frame in enumerate(frames):
        assert cv2.imwrite(str(tmp_path / f"frames/{row:06d}.png"), frame)
    return Recording(
        arm=nominal_arm(),
        sample=make_samples(3),
        time_s=np.full(3, np.nan),
        trajectory=np.array(["poses"] * 3),
        q_cmd=POSES,
        camera=webcam,
        arm_plane_z_mm=PLANE_MM,
        folder=tmp_path,
    )


def test_markers_and_their_noise_are_measured(recording: Recording, webcam: Camera) -> None:
    measured = measure_recording(recording)
    truth = [project(webcam, robot_to_board(p, BASE_MM)) for p in marker_positions(nominal_arm(), POSES)]
    for k, name in enumerate("abcf"):
        rows = [0, 2] if name == "b" else [0, 1, 2]
        assert measured.markers_px[name][rows] == pytest.approx(np.stack(truth)[rows, k], abs=0.03)
    assert np.isnan(measured.markers_px["b"][1]).all()
    assert measured.pixel_noise_px is not None
    assert 0.001 < measured.pixel_noise_px < 0.01


def test_each_frame_says_what_is_hidden(recording: Recording) -> None:
    readings = measure_frames(recording)
    assert [reading.status["b"] for reading in readings] == ["seen", "hidden", "seen"]
    assert "marker b is hidden" in readings[1].messages[0]


def test_the_base_of_a_complete_frame_names_what_one_frame_alone_cannot(recording: Recording) -> None:
    image = cv2.imread(str(recording.folder / "frames/000001.png"))
    measured = measure_recording(recording).markers_px
    for name in "cf":
        cv2.circle(image, np.rint(measured[name][1]).astype(int).tolist(), 30, (15, 15, 25), -1)
    cv2.imwrite(str(recording.folder / "frames/000001.png"), image)
    assert set(measure_frames(recording)[1].discs) == {"a"}


def test_the_paper_s_detector_fills_the_same_columns_without_noise(recording: Recording) -> None:
    measured = measure_recording(recording, "paper")
    assert measured.pixel_noise_px is None
    assert np.isfinite(measured.markers_px["a"]).sum() >= 4


def test_progress_is_told(recording: Recording) -> None:
    told: list[tuple[int, int]] = []
    measure_recording(recording, progress=lambda done, n: told.append((done, n)))
    assert told == [(1, 3), (2, 3), (3, 3)]


def test_a_missing_frame_is_named(recording: Recording) -> None:
    (recording.folder / "frames/000001.png").unlink()
    with pytest.raises(RecordingError, match=r"frames/000001.png \(sample 1\): missing"):
        measure_recording(recording)


@pytest.mark.parametrize("content", [b"", b"no picture", b"\x89PNG\r\n\x1a\n"])
def test_a_file_that_is_no_picture_is_named(recording: Recording, content: bytes) -> None:
    (recording.folder / "frames/000002.png").write_bytes(content)
    with pytest.raises(RecordingError, match=r"frames/000002.png \(sample 2\): not a PNG picture"):
        measure_recording(recording)


def test_a_truncated_picture_is_corrupt(recording: Recording) -> None:
    path = recording.folder / "frames/000000.png"
    path.write_bytes(path.read_bytes()[:60])
    with pytest.raises(RecordingError, match=r"frames/000000.png .* corrupt picture"):
        measure_recording(recording)


def test_a_frame_of_another_size_is_named_before_it_is_decoded(recording: Recording) -> None:
    path = recording.folder / "frames/000001.png"
    data = bytearray(path.read_bytes())
    data[16:24] = (60000).to_bytes(4, "big") * 2  # a header that claims ten gigabytes
    path.write_bytes(bytes(data))
    with pytest.raises(RecordingError, match=r"60000x60000 px, recording.json's camera has 1280x720"):
        measure_recording(recording)


def test_no_marker_in_any_frame_is_an_error(recording: Recording) -> None:
    for row in range(3):
        cv2.imwrite(str(recording.folder / f"frames/{row:06d}.png"), np.full((720, 1280, 3), 40, np.uint8))
    with pytest.raises(RecordingError, match="no marker in any of the 3 frames; no red disc at all"):
        measure_recording(recording)


def test_a_recording_without_a_camera_is_refused(recording: Recording) -> None:
    with pytest.raises(RecordingError, match="key 'camera' is missing"):
        measure_recording(replace(recording, camera=None))


def test_a_recording_in_memory_has_no_frames(recording: Recording) -> None:
    with pytest.raises(RecordingError, match="it has no frames"):
        measure_recording(replace(recording, folder=None))
