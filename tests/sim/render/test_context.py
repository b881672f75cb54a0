"""A context is had without a display, by EGL or OSMesa; where there is neither, the message says what to install."""

from __future__ import annotations

import ctypes.util
import os
import subprocess
import sys
from pathlib import Path

import pytest

from armtwin.models.errors import JobError
from armtwin.sim.render import context

DRAW = """
import hashlib
from armtwin.sim.render import LensRenderer, panel_parts, arm_parts, planar_arm_poses, robot_bodies_on_board
from tests.sim.render.cameras import webcam
lengths = [120.0, 121.7, 38.0, 6.73]
with LensRenderer(webcam(), [*panel_parts(), *arm_parts(lengths)], shadows=True) as renderer:
    poses = robot_bodies_on_board(planar_arm_poses(lengths, [0.1, 0.2, 0.3]), [-60.0, -50.0, -80.87])
    print(hashlib.sha256(renderer.render(poses).tobytes()).hexdigest())
"""


def drawn_by(platform: str) -> str:
    without_display = {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "WAYLAND_DISPLAY")}
    run = subprocess.run(
        [sys.executable, "-c", DRAW],
        capture_output=True,
        text=True,
        cwd=Path(__file__).parents[3],
        env=without_display | {"PYOPENGL_PLATFORM": platform},
    )
    assert run.returncode == 0, run.stderr
    return run.stdout


@pytest.mark.skipif(ctypes.util.find_library("OSMesa") is None, reason="libosmesa6 is not installed")
def test_osmesa_draws_the_same_picture_as_egl() -> None:
    assert drawn_by("osmesa") == drawn_by("egl")


def test_egl_is_chosen_where_it_works(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("PYOPENGL_PLATFORM", raising=False)
    monkeypatch.setattr(context, "egl_works", lambda: True)
    assert context.choose_platform() == "egl"


def test_osmesa_is_chosen_where_egl_does_not_work(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("PYOPENGL_PLATFORM", raising=False)
    monkeypatch.setattr(context, "egl_works", lambda: False)
    monkeypatch.setattr(ctypes.util, "find_library", lambda name: f"lib{name}.so.8")
    assert context.choose_platform() == "osmesa"


def test_a_machine_with_neither_is_told_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("PYOPENGL_PLATFORM", raising=False)
    monkeypatch.setattr(context, "egl_works", lambda: False)
    monkeypatch.setattr(ctypes.util, "find_library", lambda _: None)
    with pytest.raises(JobError, match=r"apt-get install libegl1 libgl1-mesa-dri"):
        context.choose_platform()


def test_a_missing_library_is_no_working_egl(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(_: str) -> None:
        raise OSError("libEGL.so.1: cannot open shared object file")

    monkeypatch.setattr(ctypes, "CDLL", missing)
    assert not context.egl_works()


def test_a_platform_that_needs_a_display_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYOPENGL_PLATFORM", "glx")
    with pytest.raises(JobError, match="'glx'"):
        context.choose_platform()
