"""`armtwin bench-check`: whether the bench is wired as its file says."""

from __future__ import annotations

import sys
from typing import Annotated

import typer
from rich.console import Console
from rich.text import Text

from armtwin.hardware.bench.bench_check import Finding, run_bench_check
from armtwin.hardware.bench.bench_file import BenchSetup
from armtwin.hardware.bench.hardware_bench import HardwareBench
from armtwin.models.errors import InputError, JobError
from armtwin.scenarios.benches.door import bench_setup
from armtwin.scenarios.benches.spec import EMULATED
from armtwin.scenarios.commands.interrupts import ended_as_by_ctrl_c
from armtwin.scenarios.marker_finder import marker_finder


def bench_check_command(
    bench: Annotated[str, typer.Option("--bench", help="Bench file (TOML), or 'emulated'.")],
    yes: Annotated[bool, typer.Option("--yes", help="Do not wait for Enter: the arm stands in its rest pose.")] = False,
) -> None:
    """Move each joint a little and tell from the picture whether sign, joint order, scale and markers are right.

    Put the limp arm into its rest pose first (motion.rest_rad, the drawing's zero pose if the file names none).
    Exit 1 if something is wrong.

    Example: armtwin bench-check --bench emulated
    """
    with bench_setup(bench) as setup:
        _wait_for_person(setup, yes or bench == EMULATED)
        findings = check_bench(setup)
    console = Console(highlight=False, soft_wrap=True)
    for finding in findings:
        mark, colour = ("ok  ", "green") if finding.good else ("FAIL", "red")
        console.print(Text.assemble((mark, colour), f"  {finding.text}"))
    wrong = sum(not finding.good for finding in findings)
    if wrong:
        raise JobError(f"{wrong} of {len(findings)} findings are wrong; mend them before a capture")


def check_bench(setup: BenchSetup) -> list[Finding]:
    """Run the check; the servos are detached at its end, on every error and when the terminal is closed."""
    finder = marker_finder(setup.arm, setup.camera, setup.arm_plane_z_mm)
    with ended_as_by_ctrl_c(), HardwareBench(setup, finder) as bench:
        return run_bench_check(bench)


def _wait_for_person(setup: BenchSetup, yes: bool) -> None:
    if yes:
        return
    if not sys.stdin.isatty():
        raise InputError("bench-check: someone has to put the arm into its rest pose; say --yes when it stands there")
    angles = ", ".join(f"{angle:.2f}" for angle in setup.rest_rad)
    typer.prompt(f"Put the limp arm into its rest pose ({angles} rad), keep clear, press Enter", "", show_default=False)
