"""`armtwin doctor`: whether this machine and its bench are ready, one line each."""

from __future__ import annotations

import time
from contextlib import nullcontext
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich.console import Console
from rich.text import Text

from armtwin.hardware.doctor import Check, run_checks
from armtwin.models.arm import nominal_arm
from armtwin.models.camera_files import nominal_camera
from armtwin.models.errors import JobError
from armtwin.scenarios.benches.door import bench_setup
from armtwin.sim.render import LensRenderer, arm_parts, panel_parts, planar_arm_poses, robot_bodies_on_board

_MARKS = {True: ("ok  ", "green"), False: ("FAIL", "red"), None: ("?   ", "yellow")}


def doctor_command(
    bench: Annotated[
        str | None,
        typer.Option("--bench", help="Bench file (TOML), or 'emulated'; without it the machine is looked at."),
    ] = None,
    out: Annotated[Path, typer.Option("--out", help="Folder that recordings will go to.")] = Path(),
) -> None:
    """Check renderer, permissions, serial port, firmware, camera and disk, with a remedy for what is missing.

    Nothing moves. Exit 1 if a check fails.

    Example: armtwin doctor --bench emulated
    """
    folder = next(path for path in (out.absolute(), *out.absolute().parents) if path.is_dir())
    with nullcontext() if bench is None else bench_setup(bench) as setup:
        checks = run_checks(setup, folder, describe_renderer)
    console = Console(highlight=False, soft_wrap=True)
    for check in checks:
        console.print(_line(check))
    failed = sum(check.good is False for check in checks)
    if failed:
        raise JobError(f"{failed} of {len(checks)} checks failed; the lines above say what to do")


def describe_renderer() -> str:
    """Draw the arm once and say how long a frame takes; raises `JobError` where there is no off-screen OpenGL."""
    arm, camera = nominal_arm(), nominal_camera()
    q = np.zeros(arm.n_joints)
    poses = robot_bodies_on_board(planar_arm_poses(arm.link_lengths_mm, q), np.array([0.0, 0.0, -80.87]))
    with LensRenderer(camera, [*panel_parts(), *arm_parts(arm.link_lengths_mm)]) as renderer:
        renderer.render(poses)
        started = time.perf_counter()
        image = renderer.render(poses)
        took_ms = 1000.0 * (time.perf_counter() - started)
    if image.std() < 1.0:
        raise JobError("the renderer draws an empty picture; install Mesa's software driver (libgl1-mesa-dri)")
    return f"draws {camera.image_width}x{camera.image_height} in {took_ms:.0f} ms"


def _line(check: Check) -> Text:
    mark, colour = _MARKS[check.good]
    return Text.assemble((mark, colour), f"  {check.name:<12} {check.text}")
