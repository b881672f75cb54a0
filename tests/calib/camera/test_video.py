"""From a video the sharp frames are taken that show the board in different places."""

import cv2
import numpy as np
import pytest

from armtwin.calib.camera import Board, calibrate_camera
from armtwin.calib.camera.video import views_of_video
from armtwin.models.errors import InputError

BOARD = Board(9, 6, 23.0)
K = np.array([[600.0, 0.0, 322.0], [0.0, 600.0, 237.0], [0.0, 0.0, 1.0]])


def frame(tilt, blur: float) -> np.ndarray:
    """A board seen without distortion, 640x480, smeared sideways by a motion of `blur` px."""
    per_square, fine = 40, 2
    flat = np.full((9 * per_square, 12 * per_square), 210, np.uint8)
    for row in range(7):
        for column in range(10):
            if (row + column) % 2 == 0:
                y, x = (row + 1) * per_square, (column + 1) * per_square
                flat[y : y + per_square, x : x + per_square] = 40
    R = cv2.Rodrigues(np.array(tilt, float))[0]
    to_mm = np.array([[23 / per_square, 0, -138.0], [0, 23 / per_square, -103.5], [0, 0, 1.0]])
    H = K @ np.column_stack([R[:, 0], R[:, 1], [0.0, 0.0, 420.0]]) @ to_mm
    finer = np.array([[fine, 0, (fine - 1) / 2], [0, fine, (fine - 1) / 2], [0, 0, 1.0]])
    large = cv2.warpPerspective(flat, finer @ H, (640 * fine, 480 * fine), borderValue=210)
    gray = cv2.resize(large, (640, 480), interpolation=cv2.INTER_AREA)
    return gray if blur < 1 else cv2.blur(gray, (int(blur), 1))


@pytest.fixture(scope="module")
def film(tmp_path_factory):
    """Forty frames of a board that is turned about, each third one smeared; then ten of it held still."""
    path = tmp_path_factory.mktemp("film") / "turn.avi"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"MJPG"), 30.0, (640, 480))
    assert writer.isOpened()
    for i in range(40):
        angle = 2.0 * np.pi * i / 40
        gray = frame((0.5 * np.cos(angle), 0.5 * np.sin(angle), 0.1), 7.0 if i % 3 == 1 else 0.0)
        writer.write(cv2.cvtColor(gray, cv2.COLOR_GRAY2BGR))
    for _ in range(10):
        writer.write(cv2.cvtColor(frame((0.5, 0.0, 0.1), 0.0), cv2.COLOR_GRAY2BGR))
    writer.release()
    return path


def test_frames_are_chosen_by_sharpness_and_by_what_they_add(film):
    views, size, looked = views_of_video(film, BOARD)
    assert size == (640, 480)
    assert looked == 50
    assert 5 <= len(views) <= 20
    numbers = [round(float(view.name.split(" at ")[1].split()[0]) * 30) for view in views]
    assert not [n for n in numbers if n < 40 and n % 3 == 1]  # smeared
    assert len([n for n in numbers if n >= 40]) <= 1  # held still: as the first frame
    fit = calibrate_camera(views, BOARD, size)
    np.testing.assert_allclose(fit.camera.K, K, atol=8.0)


def test_what_is_no_video_is_refused(tmp_path):
    (tmp_path / "a.mp4").write_bytes(b"no video at all")
    with pytest.raises(InputError, match=r"a\.mp4: found no video that can be read"):
        views_of_video(tmp_path / "a.mp4", BOARD)
