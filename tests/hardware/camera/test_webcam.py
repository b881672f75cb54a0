"""Against real streams over loopback and a real video file."""

import contextlib
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest

from armtwin.hardware.bench.tables import CameraSettings
from armtwin.hardware.camera.webcam import WARM_UP_PICTURES, CameraLostError, Webcam
from armtwin.hardware.emulator.mjpeg import MjpegServer, to_jpeg
from armtwin.models.errors import InputError

SIZE = (640, 360)
PASSAGE_S = 0.3  # many times what a picture takes through loopback and the decoder


class Streamer:
    """Publishes pictures from a thread until told otherwise."""

    def __init__(self, picture: Callable[[], np.ndarray]) -> None:
        self.server = MjpegServer()
        self.picture = picture
        self.mode = "live"  # live, frozen, stalled
        self._stop = threading.Event()
        self._last = to_jpeg(picture())
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self) -> None:
        while not self._stop.wait(0.02):
            if self.mode == "live":
                self._last = to_jpeg(self.picture())
            if self.mode != "stalled":
                self.server.publish(self._last)

    def close(self) -> None:
        self._stop.set()
        self._thread.join()
        self.server.close()


@pytest.fixture
def streamer(scene) -> Iterator[Streamer]:
    running = Streamer(scene.picture)
    yield running
    running.close()


def settings(source: str, **more: float) -> CameraSettings:
    return CameraSettings(source=source, calibration="camera.yaml", arm_plane_z_mm=0.0, **more)


def watch(camera: Webcam, timeout_s: float | None = None) -> None:
    """Ask for one picture after the other, for ever."""
    while True:
        camera.after(camera.newest().number, timeout_s)


@pytest.fixture
def webcam(streamer: Streamer) -> Iterator[Webcam]:
    with Webcam(settings(streamer.server.url), *SIZE, frozen_s=0.5) as camera:
        yield camera


def test_gives_pictures_of_the_stream(webcam: Webcam):
    picture = webcam.newest()

    assert picture.image.shape == (360, 640, 3)
    assert picture.image.dtype == np.uint8


def test_after_gives_a_picture_with_a_higher_number(webcam: Webcam):
    first = webcam.newest()

    assert webcam.after(first.number).number > first.number


def test_the_newest_picture_is_the_last_that_was_sent_after_a_pause_without_questions(
    webcam: Webcam, streamer: Streamer, scene
):
    """The changed scene is sent once and nothing behind it, so that a queue of one picture would show."""
    webcam.newest()
    time.sleep(0.5)  # some 25 pictures
    streamer.mode = "stalled"
    time.sleep(PASSAGE_S)
    scene.angle_rad = 1.0
    changed = scene.picture()
    streamer.server.publish(to_jpeg(changed))
    time.sleep(PASSAGE_S)

    difference = np.abs(webcam.newest().image.astype(int) - changed)

    assert difference.max() < 20  # of a JPEG; the bar that has turned is 100 grey levels off


def test_a_frozen_stream_is_told_from_a_still_scene(webcam: Webcam, streamer: Streamer):
    streamer.mode = "frozen"

    with pytest.raises(CameraLostError, match="frozen, the same picture"):
        watch(webcam)


def test_a_stalled_stream_is_lost(webcam: Webcam, streamer: Streamer):
    streamer.mode = "stalled"

    with pytest.raises(CameraLostError, match=r"no new picture for 0\.5 s"):
        watch(webcam)


def test_a_stream_that_breaks_off_is_lost_also_for_who_asks_for_the_newest(webcam: Webcam, streamer: Streamer):
    streamer.mode = "stalled"
    streamer.server.drop_clients()

    with pytest.raises(CameraLostError, match="the stream broke off"):
        watch(webcam, timeout_s=5.0)
    with pytest.raises(CameraLostError, match="the stream broke off"):
        webcam.newest()


def test_a_stream_of_another_size_is_refused(streamer: Streamer):
    with pytest.raises(InputError, match=r"image_width 1280 \(it answered 640\)"):
        Webcam(settings(streamer.server.url), 1280, 720).open()


def test_a_stream_of_broken_pictures_is_said_to_give_none(streamer: Streamer):
    streamer.mode = "stalled"
    stop = threading.Event()
    broken = to_jpeg(streamer.picture())[:600] + b"\xff\xd9"

    def publish() -> None:
        while not stop.wait(0.02):
            streamer.server.publish(broken)

    thread = threading.Thread(target=publish)
    thread.start()
    try:
        with pytest.raises(InputError, match="no picture of it could be read"):
            Webcam(settings(streamer.server.url), *SIZE).open()
    finally:
        stop.set()
        thread.join()


def test_a_stream_takes_no_settings(streamer: Streamer):
    with pytest.raises(InputError, match="a stream takes no focus"):
        Webcam(settings(streamer.server.url, focus=30), *SIZE).open()


def test_nothing_at_the_address_is_said_plainly(streamer: Streamer):
    url = streamer.server.url.replace("/stream", "/other")

    with pytest.raises(InputError, match=r"there is no such page on its server \(404\)"):
        Webcam(settings(url), *SIZE).open()


def test_missing_device_is_named_with_those_that_are_there():
    with pytest.raises(InputError, match=r"camera /dev/video97: no such device; found .*Check the cable"):
        Webcam(settings("/dev/video97"), *SIZE).open()


def test_a_device_that_is_no_camera_cannot_be_opened(tmp_path: Path):
    with pytest.raises(InputError, match="camera /dev/null: cannot be opened"):
        Webcam(settings("/dev/null"), *SIZE).open()


def test_missing_file_is_named(tmp_path: Path):
    with pytest.raises(InputError, match="no such file"):
        Webcam(settings(str(tmp_path / "none.avi")), *SIZE).open()


def test_a_camera_without_pictures_is_released_again(streamer: Streamer, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("armtwin.hardware.camera.webcam.OPEN_TIMEOUT_S", 0.5)
    streamer.mode = "frozen"  # one picture, where the warm-up wants some
    camera = Webcam(settings(streamer.server.url), *SIZE)

    with pytest.raises(CameraLostError, match="the same picture"):
        camera.open()

    assert "webcam" not in {thread.name for thread in threading.enumerate()}


def test_a_closed_camera_has_no_picture(streamer: Streamer):
    camera = Webcam(settings(streamer.server.url), *SIZE)
    camera.open()
    camera.close()

    with pytest.raises(CameraLostError, match="not open"):
        camera.newest()


def test_a_camera_that_was_lost_can_be_opened_again(streamer: Streamer):
    camera = Webcam(settings(streamer.server.url), *SIZE)
    camera.open()
    streamer.server.drop_clients()
    with pytest.raises(CameraLostError, match="broke off"):
        watch(camera, timeout_s=5.0)
    camera.close()

    with camera:
        assert camera.after(camera.newest().number).number > WARM_UP_PICTURES


def test_closing_twice_is_safe(streamer: Streamer):
    camera = Webcam(settings(streamer.server.url), *SIZE)
    camera.open()
    camera.close()
    camera.close()


@pytest.fixture
def video(tmp_path: Path, scene) -> Path:
    path = tmp_path / "scene.avi"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), 50.0, SIZE)
    for _ in range(25):
        writer.write(scene.picture())
    writer.release()
    return path


def test_a_video_file_is_lost_at_its_end(video: Path):
    with Webcam(settings(str(video)), *SIZE) as camera, pytest.raises(CameraLostError, match="at its end"):
        watch(camera)


def test_no_picture_of_a_video_file_is_rushed_past(video: Path):
    """A file is read at its own rate, so that whoever asks often enough sees every picture of it."""
    numbers = []
    with Webcam(settings(str(video)), *SIZE) as camera, contextlib.suppress(CameraLostError):
        while True:
            numbers.append(camera.after(numbers[-1] if numbers else 0).number)

    assert numbers[-1] == 25
