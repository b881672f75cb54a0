"""An effect from outside the package, as the page on effects shows it, is found in data that know nothing of it."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest

import armtwin.models
from armtwin.calib.diagnosis.diagnosis import diagnose
from armtwin.models.arm import nominal_arm
from armtwin.models.camera_files import nominal_camera
from armtwin.models.catalogue import registry
from armtwin.models.catalogue.registry import catalogue, register_file
from armtwin.models.recordings.recording import Recording, make_samples
from armtwin.scenarios.diagnosis.findings import estimates_of, twin_of
from armtwin.scenarios.diagnosis.resimulate import compare

PAGE = Path(armtwin.models.__file__).parent / "effects" / "README.md"
STOP_RAD = 0.21
NOISE_PX = 0.08


@pytest.fixture
def _end_stop(tmp_path: Path) -> Iterator[None]:
    """Register the page's example, and forget it afterwards."""
    known = dict(catalogue())
    example = re.search(r"```python\n(.*?)```", PAGE.read_text("utf-8"), re.DOTALL)
    assert example is not None
    path = tmp_path / "end_stop.py"
    path.write_text(example[1])
    assert register_file(path).name == "end_stop"
    yield
    registry._LOADED.clear()
    registry._LOADED.update(known)


def blocked_arm(n: int = 120) -> Recording:
    """Return a recording of an arm whose second joint is blocked, from trigonometry and OpenCV's projection alone."""
    rng = np.random.default_rng(5)
    steps = np.linspace(0.0, 6.0 * np.pi, n)
    q = 0.35 * np.stack([np.sin(steps), np.sin(0.7 * steps + 1.0), np.cos(0.9 * steps)], axis=-1)
    reached = q.copy()
    reached[reached[:, 1] > STOP_RAD, 1] = STOP_RAD
    first, second, third = np.cumsum(reached + np.pi / 2, axis=1).T
    l1, l2, l4, l5 = 121.0, 120.5, 38.6, 6.83
    b = np.stack([l1 * np.cos(first), l1 * np.sin(first)], axis=-1)
    c = b + np.stack([l2 * np.cos(second), l2 * np.sin(second)], axis=-1)
    f = c + np.stack([l4 * np.cos(third) + l5 * np.sin(third), l4 * np.sin(third) - l5 * np.cos(third)], axis=-1)
    camera = nominal_camera()
    pixels = {}
    for name, points in (("a", np.zeros((n, 2))), ("b", b), ("c", c), ("f", f)):
        board = np.stack([40.0 - points[:, 0], points[:, 1] - 33.0, np.full(n, -80.87)], axis=-1)
        turn, _ = cv2.Rodrigues(camera.R_board_camera)
        seen, _ = cv2.projectPoints(board, turn, camera.t_board_camera_mm, camera.K, camera.lens.coefficients)
        pixels[name] = seen.reshape(-1, 2) + NOISE_PX * rng.standard_normal((n, 2))
    return Recording(
        arm=nominal_arm(),
        camera=camera,
        arm_plane_z_mm=-80.87,
        pixel_noise_px=NOISE_PX,
        sample=make_samples(n),
        time_s=np.full(n, np.nan),
        trajectory=np.repeat(["one", "two", "three", "four"], n // 4),
        q_cmd=q,
        markers_px=pixels,
    )


@pytest.mark.usefixtures("_end_stop")
def test_an_effect_of_one_s_own_is_named_measured_and_built_in_the_simulated_bench() -> None:
    recording = blocked_arm()
    found = diagnose(recording)
    assert found.verdict == "named"
    (cause,) = found.causes
    assert cause.active.key == ("end_stop", 2, None)
    limit = estimates_of(cause, found)["limit_rad"]
    assert limit.value == pytest.approx(STOP_RAD, abs=4 * limit.std)
    twin = twin_of(found)
    assert [(effect.effect, effect.joint) for effect in twin.effects] == [("end_stop", 2)]
    assert compare(found, twin, recording).held_out_rms_mm < 1.2 * found.held_out.noise_floor_mm


def test_without_it_no_other_cause_is_blamed() -> None:
    found = diagnose(blocked_arm())
    assert found.verdict == "unknown"
