"""A recording that has frames and no pixels yet is measured first."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from armtwin.models.errors import RecordingError
from armtwin.models.recordings.recording import Recording, make_samples
from armtwin.models.recordings.writer import write_recording
from armtwin.scenarios.diagnosis.measured import measured
from armtwin.sim.bench import SimulatedBench
from tests.support.worlds import PLANE_MM, flat_world

Q_CMD = np.array([[0.1, -0.1, 0.2], [-0.1, 0.1, -0.2]])


def filmed(folder: Path) -> dict[str, np.ndarray]:
    """Write a recording of two poses with their rendered frames and no markers; return where the markers truly are."""
    world = flat_world()
    bare = Recording(
        arm=world.arm,
        camera=world.camera,
        arm_plane_z_mm=PLANE_MM,
        sample=make_samples(2),
        time_s=np.full(2, np.nan),
        trajectory=np.full(2, "path"),
        q_cmd=Q_CMD,
    )
    write_recording(folder, bare)
    (folder / "frames").mkdir()
    bench = SimulatedBench(world, seed=1)
    bench.connect()
    truth = []
    for row, q in enumerate(Q_CMD):
        bench.move(q)
        cv2.imwrite(str(folder / "frames" / f"{row:06d}.png"), bench.capture().image)
        truth.append(bench.true_pixels())
    bench.close()
    return {name: np.array([one[name] for one in truth]) for name in world.arm.marker_names}


def test_its_markers_are_found_in_the_frames(tmp_path: Path) -> None:
    truth = filmed(tmp_path / "filmed")
    heard: list[str] = []
    found = measured(tmp_path / "filmed", heard.append)
    for name, pixels in truth.items():
        np.testing.assert_allclose(found.markers_px[name], pixels, atol=0.3)
    assert heard[-1] == "measuring markers: frame 2 of 2"


def test_pixels_that_are_there_already_are_kept(tmp_path: Path) -> None:
    filmed(tmp_path / "filmed")
    once = measured(tmp_path / "filmed", lambda _: None)
    write_recording(tmp_path / "filmed", replace(once, markers_px={"f": np.full((2, 2), 300.0)}))
    assert list(measured(tmp_path / "filmed", lambda _: None).markers_px) == ["f"]


def test_without_frames_a_recording_without_markers_is_refused(tmp_path: Path) -> None:
    filmed(tmp_path / "filmed")
    for frame in (tmp_path / "filmed" / "frames").iterdir():
        frame.unlink()
    (tmp_path / "filmed" / "frames").rmdir()
    with pytest.raises(RecordingError, match="neither markers"):
        measured(tmp_path / "filmed", lambda _: None)
