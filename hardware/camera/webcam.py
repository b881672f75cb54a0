"""The webcam over OpenCV: a V4L2 device, an MJPEG stream over HTTP or a video file; always its newest picture.

A thread reads without pause, so that no driver's or socket's queue holds old frames:

    camera   f1  f2  f3  f4  f5  f6
    thread   f1  f2  f3  f4  f5  f6       each replaces the one before
    caller           ^f3         ^f6      what was there when it asked, or the next one

A picture equal to the one before, bit by bit, is no new picture: a sensor's noise never repeats, a stuck stream does.
"""

from __future__ import annotations

import os
import threading
import time
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from armtwin.hardware.bench.tables import CameraSettings
from armtwin.hardware.camera.settings import apply_settings, read_back, refuse_mismatch
from armtwin.hardware.camera.stream_faults import what_it_gives
from armtwin.models.errors import InputError, JobError

OPEN_TIMEOUT_S = 5.0
# FFmpeg gives up on a silent stream after this; the frozen stream is noticed earlier, by its own bound.
READ_TIMEOUT_S = 3.0
_STREAMS = ("http://", "https://")
# About one compressed picture of 720p.
_RECEIVE_BUFFER_BYTES = 1 << 18
# Automatic exposure, and a driver's queue from before the settings, need a few pictures.
WARM_UP_PICTURES = 3
_DEFAULT_VIDEO_RATE_HZ = 25.0


class CameraLostError(JobError):
    """The camera gives no new pictures any more."""


@dataclass(frozen=True, eq=False)
class Picture:
    """One new picture: (H, W, 3) uint8 BGR, its arrival on the monotonic clock, its number from 1."""

    image: NDArray[np.uint8]
    arrived_s: float
    number: int


class Webcam:
    """A camera that is read by a thread; use as a context manager or `open` and `close`."""

    def __init__(self, settings: CameraSettings, width: int, height: int, frozen_s: float = 1.0) -> None:
        """Note what is wanted; `settings.source` of a video file is a path that can be opened from here."""
        self.source = settings.source
        self.notes: list[str] = []
        self._settings = settings
        self._size = (width, height)
        self._frozen_s = frozen_s
        self._changed = threading.Condition()
        self._picture: Picture | None = None
        self._repeats = 0
        self._lost: str | None = None
        self._closing = threading.Event()
        self._thread: threading.Thread | None = None

    def open(self) -> None:
        """Open the camera, set it, read everything back and wait for its first pictures.

        Raises `InputError` for a camera that cannot be opened or refuses a setting, `CameraLostError` for one that is
        open and gives no picture. What was refused and does no harm stands in `notes`.
        """
        device = self._open_device()
        try:
            self.notes = self._settle_settings(device)
        except BaseException:
            device.release()
            raise
        self._closing.clear()
        self._thread = threading.Thread(target=self._read, args=(device,), name="webcam", daemon=True)
        self._thread.start()
        try:
            self.after(WARM_UP_PICTURES - 1, timeout_s=OPEN_TIMEOUT_S)
        except CameraLostError:
            self.close()
            self._refuse_no_stream()
            raise
        except BaseException:  # also Ctrl-C: the camera must not stay busy
            self.close()
            raise

    def newest(self) -> Picture:
        """Return the newest picture, without waiting. Raises `CameraLostError`."""
        with self._changed:
            self._refuse_lost()
            if self._picture is None:
                raise CameraLostError(f"camera {self.source}: not open")
            return self._picture

    def after(self, number: int, timeout_s: float | None = None) -> Picture:
        """Wait for a picture newer than `number`, and return the newest then.

        Raises `CameraLostError` when the camera is lost, or when for `timeout_s` (by default the bound for a frozen
        stream) nothing new came.
        """
        bound = self._frozen_s if timeout_s is None else timeout_s
        deadline = time.monotonic() + bound
        with self._changed:
            while self._picture is None or self._picture.number <= number:
                self._refuse_lost()
                left = deadline - time.monotonic()
                if left <= 0:
                    raise CameraLostError(f"camera {self.source}: {self._silence(bound)}")
                self._changed.wait(left)
            return self._picture

    def close(self) -> None:
        """Stop reading, release the camera and forget its pictures. May be called twice."""
        self._closing.set()
        if self._thread is not None and self._thread is not threading.current_thread():
            self._thread.join(READ_TIMEOUT_S + 1.0)  # a read that hangs ends by its own time limit
            self._thread = None
        with self._changed:
            self._picture, self._repeats, self._lost = None, 0, None

    def __enter__(self) -> Webcam:
        self.open()
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def is_device(self) -> bool:
        """Whether the source is a local camera, which can be set."""
        return self.source.startswith("/dev/")

    @property
    def is_stream(self) -> bool:
        """Whether the source is a stream over the network."""
        return self.source.startswith(_STREAMS)

    def _open_device(self) -> cv2.VideoCapture:
        os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")  # its warnings are no lines of ours
        # The system would else let megabytes queue up, seconds of pictures, while this machine is busy.
        os.environ.setdefault("OPENCV_FFMPEG_CAPTURE_OPTIONS", f"recv_buffer_size;{_RECEIVE_BUFFER_BYTES}")
        cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
        if self.is_device:
            self._refuse_device()
            device = cv2.VideoCapture(self.source, cv2.CAP_V4L2)
        else:
            if not self.is_stream and not Path(self.source).is_file():
                raise InputError(
                    f"camera {self.source}: no such file; camera.source is a device like /dev/video0, "
                    "a stream like http://127.0.0.1:8080/stream, or a video file"
                )
            limits = [cv2.CAP_PROP_OPEN_TIMEOUT_MSEC, int(OPEN_TIMEOUT_S * 1000)]
            limits += [cv2.CAP_PROP_READ_TIMEOUT_MSEC, int(READ_TIMEOUT_S * 1000)]
            device = cv2.VideoCapture(self.source, cv2.CAP_FFMPEG, limits)
        if not device.isOpened():
            device.release()
            self._refuse_no_stream()
            what = "is it an MJPEG stream?" if self.is_stream else "is it a camera or video, and free?"
            raise InputError(f"camera {self.source}: cannot be opened; {what}")
        return device

    def _refuse_no_stream(self) -> None:
        """Say what the address gives where that is no stream."""
        found = what_it_gives(self.source) if self.is_stream else None
        if found is not None:
            raise InputError(f"camera {self.source}: {found}")

    def _refuse_device(self) -> None:
        if not Path(self.source).exists():
            found = ", ".join(str(path) for path in sorted(Path("/dev").glob("video*"))) or "none"
            raise InputError(f"camera {self.source}: no such device; found {found}. Check the cable and camera.source")
        if not os.access(self.source, os.R_OK | os.W_OK):
            raise InputError(
                f"camera {self.source}: no permission; join its group with 'sudo usermod -aG video $USER', "
                "then log out and in again"
            )

    def _settle_settings(self, device: cv2.VideoCapture) -> list[str]:
        width, height = self._size
        if self.is_device:
            return refuse_mismatch(self.source, apply_settings(device, self._settings, width, height))
        for key in ("focus", "exposure", "white_balance_k"):
            if getattr(self._settings, key) is not None:
                kind = "a stream" if self.is_stream else "a video file"
                raise InputError(f"camera {self.source}: {kind} takes no {key}; set it where it is made, drop the key")
        rateless = self._settings.model_copy(update={"fps": None})
        return refuse_mismatch(self.source, read_back(device, rateless, width, height))

    def _read(self, device: cv2.VideoCapture) -> None:
        """Read until closed or lost; the thread's body, which also releases the device: OpenCV allows no other to."""
        pause_s = 0.0
        if not (self.is_device or self.is_stream):  # a file would be over at once
            rate = device.get(cv2.CAP_PROP_FPS)
            pause_s = 1.0 / (rate if 0.1 < rate < 1000 else _DEFAULT_VIDEO_RATE_HZ)
        try:
            while not self._closing.wait(pause_s):
                good, image = device.read()
                if not good:
                    self._lose(
                        "the stream broke off" if self.is_stream else "no picture came: unplugged, or at its end"
                    )
                    return
                self._take(np.asarray(image, dtype=np.uint8))
        except cv2.error as error:
            self._lose(f"OpenCV failed to read it ({error.err})")
        finally:
            device.release()

    def _take(self, image: NDArray[np.uint8]) -> None:
        width, height = self._size
        if image.shape != (height, width, 3):
            self._lose(f"the picture became {image.shape[1]}x{image.shape[0]}, {width}x{height} is calibrated")
            return
        now = time.monotonic()
        with self._changed:
            if self._picture is not None and np.array_equal(self._picture.image, image):
                self._repeats += 1
                return
            self._repeats = 0
            self._picture = Picture(image, now, 1 if self._picture is None else self._picture.number + 1)
            self._changed.notify_all()

    def _lose(self, why: str) -> None:
        with self._changed:
            self._lost = why
            self._changed.notify_all()

    def _refuse_lost(self) -> None:
        if self._lost is not None:
            raise CameraLostError(f"camera {self.source}: lost, {self._lost}; check its cable and start again")

    def _silence(self, bound_s: float) -> str:
        if self._repeats:
            return (
                f"frozen, the same picture {self._repeats + 1} times in {bound_s:g} s; restart the camera or its stream"
            )
        return f"no new picture for {bound_s:g} s; check its cable, or the stream's server"
