"""A film of a moving arm as the log that it shows: the angle of each joint in each picture, by its markers."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from armtwin.hardware.bench.posture import joint_angles, link_vectors_mm
from armtwin.hardware.capture.film import header_in_motion
from armtwin.models import atomic
from armtwin.models.errors import RecordingError
from armtwin.models.recordings.recording import Recording
from armtwin.models.recordings.writer import samples_csv


def angles_of_film(film: Recording) -> Recording:
    """Return the recording of joint angles, rad, that a film's markers show; NaN where one of a picture is hidden.

    A link's direction is that of the line from its marker to the next, so wrong lengths do not turn it; joints that
    are built off their drawn zero show as an offset. Raises `RecordingError` for a recording without a camera.
    """
    if film.camera is None or film.arm_plane_z_mm is None:
        raise RecordingError("recording.json: key 'camera' is missing; a film's markers are pixels of a known camera")
    q = np.full(film.q_cmd.shape, np.nan)
    for row in range(len(film)):
        markers = {name: pixels[row] for name, pixels in film.markers_px.items()}
        links = link_vectors_mm(film.arm, film.camera, film.arm_plane_z_mm, markers)
        if links is not None:
            q[row] = joint_angles(film.arm, links)
    return replace(film, q_meas=q, markers_px={}, camera=None, arm_plane_z_mm=None, pixel_noise_px=None)


def write_moving(folder: Path, recording: Recording) -> None:
    """Write a log of joint angles as a moving recording, each file atomically."""
    atomic.write_json(folder / "recording.json", header_in_motion(recording))
    atomic.write_text(folder / "samples.csv", samples_csv(recording))
