"""Markers of a whole recording from its frames."""

from __future__ import annotations

import struct
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np

from armtwin.calib.markers.detect import detect
from armtwin.calib.markers.disc import DetectorConfig, Disc, Image, Method
from armtwin.calib.markers.identify import identify
from armtwin.calib.markers.reading import MarkerReading
from armtwin.calib.markers.slipped import slipped_commands
from armtwin.models.camera import Camera, back_project
from armtwin.models.errors import RecordingError
from armtwin.models.recordings.recording import Recording

# A frame of 1280 x 720 is 2.8 MB as it stands; larger files are no frames of a webcam.
_MOST_BYTES = 64 << 20
# Length of a PNG file up to the picture's width and height, which end it (PNG specification, section 11.2.2).
_PNG_HEADER = 24


def measure_recording(
    recording: Recording,
    method: Method = "subpixel",
    config: DetectorConfig | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Recording:
    """Return the recording with `markers_px` (and, from "subpixel", `pixel_noise_px`) measured in its frames.

    `progress` is called with the frames done and their number. Raises `RecordingError` for a recording without camera
    or folder, a frame that is missing, corrupt or of another size, and where no frame shows any marker.
    """
    return with_markers(recording, measure_frames(recording, method, config, progress))


def with_markers(recording: Recording, readings: tuple[MarkerReading, ...]) -> Recording:
    """Return the recording with the readings of its N rows in place of its markers."""
    names = recording.arm.marker_names
    markers = {name: np.array([r.pixels[name] for r in readings]).reshape(-1, 2) for name in names}
    covariances = np.array([r.covariances[name] for r in readings for name in names]).reshape(-1, 2, 2)
    variances = np.trace(covariances, axis1=1, axis2=2) / 2.0
    known = variances[np.isfinite(variances)]
    noise = float(np.sqrt(np.median(known))) if len(known) else None
    return replace(recording, markers_px=markers, pixel_noise_px=noise)


def measure_frames(
    recording: Recording,
    method: Method = "subpixel",
    config: DetectorConfig | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> tuple[MarkerReading, ...]:
    """Return the markers of each frame, in the recording's order; see `measure_recording`.

    Frames in which not every marker is clear are read again with the base where the nearest complete frame has it, and
    those in which a link stands off its command by the same turn in many frames, by that turn.
    """
    camera, plane_z_mm = _calibration(recording)
    found: list[tuple[Disc, ...]] = []
    readings: list[MarkerReading] = []
    for row in range(len(recording)):
        image = read_frame(recording, row)
        found.append(detect(image, method, camera, plane_z_mm, config))
        readings.append(identify(found[-1], recording.arm, camera, plane_z_mm, recording.q_cmd[row]))
        if progress is not None:
            progress(row + 1, len(recording))
    base = recording.arm.marker_names[0]
    complete = [row for row, reading in enumerate(readings) if reading.is_complete]
    for row, reading in enumerate(readings):
        if complete and not reading.is_complete:
            nearest = min(complete, key=lambda other: abs(other - row))
            hint = back_project(camera, readings[nearest].pixels[base][None], plane_z_mm)[0]
            readings[row] = identify(found[row], recording.arm, camera, plane_z_mm, recording.q_cmd[row], hint)
    slipped = slipped_commands(found, readings, recording.arm, camera, plane_z_mm, recording.q_cmd)
    for row, q in slipped.items():
        readings[row] = identify(found[row], recording.arm, camera, plane_z_mm, q)
    if not any(reading.discs for reading in readings):
        raise RecordingError(f"{_frames(recording)}: no marker in any of the {len(recording)} frames; {_advice(found)}")
    return tuple(readings)


def read_frame(recording: Recording, row: int) -> Image:
    """Return the frame of a row, (H, W, 3) BGR; raises `RecordingError`: missing, corrupt, of another size."""
    camera, _ = _calibration(recording)
    path = recording.frame_path(row)
    if path is None:
        raise RecordingError("recording: made in memory, it has no frames; write it with its frames first")
    where = f"frames/{path.name} (sample {recording.sample[row]})"
    if not path.is_file():
        raise RecordingError(f"{where}: missing; every row of samples.csv needs its frame")
    if path.stat().st_size > _MOST_BYTES:
        raise RecordingError(f"{where}: {path.stat().st_size} bytes, more than the {_MOST_BYTES} that a frame may have")
    data = path.read_bytes()
    if len(data) < _PNG_HEADER or not data.startswith(b"\x89PNG\r\n\x1a\n"):
        raise RecordingError(f"{where}: not a PNG picture; capture it again or remove its row from samples.csv")
    # The size is read before anything is decoded: a small file may claim to hold a picture of gigabytes.
    width, height = struct.unpack(">II", data[16:_PNG_HEADER])
    if (width, height) != (camera.image_width, camera.image_height):
        raise RecordingError(
            f"{where}: {width}x{height} px, recording.json's camera has {camera.image_width}x{camera.image_height}"
        )
    image = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
    if image is None:
        raise RecordingError(f"{where}: a corrupt picture; capture it again or remove its row from samples.csv")
    return np.asarray(image, dtype=np.uint8)


def _calibration(recording: Recording) -> tuple[Camera, float]:
    if recording.camera is None or recording.arm_plane_z_mm is None:
        missing = "camera" if recording.camera is None else "arm_plane_z_mm"
        raise RecordingError(f"recording.json: key '{missing}' is missing; markers cannot be told apart without it")
    return recording.camera, recording.arm_plane_z_mm


def _frames(recording: Recording) -> Path:
    return Path("frames") if recording.folder is None else recording.folder / "frames"


def _advice(found: list[tuple[Disc, ...]]) -> str:
    n = sum(len(discs) for discs in found)
    if n == 0:
        return "no red disc at all: check light, focus and that the markers are red on dark"
    return (
        f"{n} red discs were found, at no distances that the arm's links explain: check the camera and link_lengths_mm"
    )
