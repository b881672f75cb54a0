"""A recording with its markers: as it was measured before, or else from its frames."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from armtwin.calib.markers import measure_recording
from armtwin.models.recordings.reader import read_recording
from armtwin.models.recordings.recording import Recording


def measured(folder: Path, tell: Callable[[str], None]) -> Recording:
    """Read a recording; where it has neither markers nor angles, measure the markers in its frames."""
    if not (folder / "frames").is_dir():
        return read_recording(folder)
    data = read_recording(folder, unmeasured=True)
    if data.markers_px or data.q_meas is not None:
        return data
    return measure_recording(data, progress=lambda done, n: tell(f"measuring markers: frame {done} of {n}"))
