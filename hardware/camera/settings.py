"""Setting a webcam and reading every setting back.

The order matters, and each step of it trips people up: the compressed format before the size (uncompressed 720p comes
at 10 Hz on USB 2), the size before the rate, and exposure, focus and white balance first handed to the camera, then
taken back, then set, since many V4L2 drivers ignore a value while their own control is, or never was, on.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import cv2

from armtwin.hardware.bench.tables import CameraSettings
from armtwin.models.errors import InputError

# V4L2's menu values of exposure_auto, which OpenCV passes through: 1 manual, 3 aperture priority.
_EXPOSURE_MANUAL = 1.0
_EXPOSURE_AUTO = 3.0
# A camera rounds to the nearest step of its own; what is further off was not taken over.
_RELATIVE_TOLERANCE = 0.02
_RATE_TOLERANCE = 0.1


class Device(Protocol):
    """The part of `cv2.VideoCapture` that settings need."""

    def set(self, propId: int, value: float, /) -> bool:
        """Ask for a value."""

    def get(self, propId: int, /) -> float:
        """Read a value back; 0 or -1 where the camera does not have it."""


@dataclass(frozen=True)
class Readback:
    """One setting: its key in the bench file, what was asked and what the camera answered."""

    key: str
    wanted: float
    found: float

    @property
    def taken(self) -> bool:
        """Whether the camera took it over."""
        tolerance = _RATE_TOLERANCE if self.key == "fps" else _RELATIVE_TOLERANCE
        return abs(self.found - self.wanted) <= tolerance * max(abs(self.wanted), 1.0)

    def __str__(self) -> str:
        return f"{self.key} {self.wanted:g} (it answered {self.found:g})"


def apply_settings(device: Device, wanted: CameraSettings, width: int, height: int) -> list[Readback]:
    """Set everything that the bench file asks for and return what the camera answered, size first."""
    device.set(cv2.CAP_PROP_FOURCC, float(cv2.VideoWriter.fourcc(*"MJPG")))
    device.set(cv2.CAP_PROP_FRAME_WIDTH, float(width))
    device.set(cv2.CAP_PROP_FRAME_HEIGHT, float(height))
    if wanted.fps is not None:
        device.set(cv2.CAP_PROP_FPS, wanted.fps)
    device.set(cv2.CAP_PROP_BUFFERSIZE, 1.0)
    if wanted.exposure is not None:
        device.set(cv2.CAP_PROP_AUTO_EXPOSURE, _EXPOSURE_AUTO)
        device.set(cv2.CAP_PROP_AUTO_EXPOSURE, _EXPOSURE_MANUAL)
        device.set(cv2.CAP_PROP_EXPOSURE, wanted.exposure)
    if wanted.focus is not None:
        device.set(cv2.CAP_PROP_AUTOFOCUS, 1.0)
        device.set(cv2.CAP_PROP_AUTOFOCUS, 0.0)
        device.set(cv2.CAP_PROP_FOCUS, wanted.focus)
    if wanted.white_balance_k is not None:
        device.set(cv2.CAP_PROP_AUTO_WB, 1.0)
        device.set(cv2.CAP_PROP_AUTO_WB, 0.0)
        device.set(cv2.CAP_PROP_WB_TEMPERATURE, wanted.white_balance_k)
    return read_back(device, wanted, width, height)


def read_back(device: Device, wanted: CameraSettings, width: int, height: int) -> list[Readback]:
    """Ask the camera for everything that the bench file wants of it."""
    asked = [
        ("image_width", cv2.CAP_PROP_FRAME_WIDTH, float(width)),
        ("image_height", cv2.CAP_PROP_FRAME_HEIGHT, float(height)),
        ("fps", cv2.CAP_PROP_FPS, wanted.fps),
        ("exposure", cv2.CAP_PROP_EXPOSURE, wanted.exposure),
        ("focus", cv2.CAP_PROP_FOCUS, wanted.focus),
        ("white_balance_k", cv2.CAP_PROP_WB_TEMPERATURE, wanted.white_balance_k),
    ]
    return [Readback(key, value, float(device.get(prop))) for key, prop, value in asked if value is not None]


def refuse_mismatch(source: str, answers: list[Readback]) -> list[str]:
    """Raise `InputError` for settings that change what is measured; return a note for a rate that was not taken over.

    A camera without any size has no pictures. A wrong size voids the calibration, and a lens, exposure or
    colour balance left to the camera changes between poses.
    """
    refused = [answer for answer in answers if not answer.taken]
    fatal = [answer for answer in refused if answer.key != "fps"]
    size = [answer for answer in fatal if answer.key.startswith("image_")]
    if size and not any(answer.found for answer in size):  # the size is that of the first picture
        raise InputError(
            f"camera {source}: opened, but no picture of it could be read: broken pictures, or a format that is not "
            "known here; look at it with another program, restart it"
        )
    if size:
        raise InputError(
            f"camera {source}: refused {', '.join(map(str, size))}; the calibration holds for this size only: "
            "choose another camera, or calibrate at a size that it has"
        )
    if fatal:
        raise InputError(
            f"camera {source}: refused {', '.join(map(str, fatal))}; use a value that it has "
            "(v4l2-ctl --list-ctrls names them), or leave the key out of [camera] if it lacks the control"
        )
    return [f"camera {source}: refused {answer}; it runs at its own rate" for answer in refused]
