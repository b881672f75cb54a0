"""`armtwin capture`: a recording of a plan, made by a real or an emulated bench."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import Progress

from armtwin.hardware.bench.bench_file import BenchSetup, read_bench
from armtwin.hardware.bench.hardware_bench import HardwareBench
from armtwin.hardware.capture.capture import ChangePayload, run_capture
from armtwin.hardware.capture.folder import CaptureFolder
from armtwin.models.errors import InputError, JobError
from armtwin.models.plan import Plan
from armtwin.scenarios.commands.interrupts import ended_as_by_ctrl_c
from armtwin.scenarios.commands.outputs import check_out_folder
from armtwin.scenarios.emulated_bench import MAX_SPEED, MIN_SPEED, EmulatedBench
from armtwin.scenarios.marker_finder import marker_finder
from armtwin.scenarios.plans import load_plan

EMULATED = "emulated"
# The paper validates on its line (section 4).
_PAPER_HELD_OUT = ("line",)
_UNHEARD = "the board does not answer and detaches the servos itself, two seconds after it last heard the program"


def capture_command(
    bench: Annotated[str, typer.Option("--bench", help="Bench file (TOML), or 'emulated'.")],
    plan: Annotated[str, typer.Option("--plan", help="'paper', or a CSV of commands or of poses.")],
    out: Annotated[Path, typer.Option("--out", help="Recording folder; one that broke off is taken up.")],
    hold_out: Annotated[
        list[str] | None, typer.Option("--hold-out", help="Trajectory to keep for validation; may be given again.")
    ] = None,
    speed: Annotated[
        float, typer.Option("--speed", min=MIN_SPEED, max=MAX_SPEED, help="Of the emulated bench, times real time.")
    ] = 1.0,
) -> None:
    """Move the arm through a plan and take a picture of every pose.

    Limits and steps of the whole plan are checked before anything moves, the arm sets out slowly from where it stands,
    each pose is on disk before the next, and the servos are detached at the end, on Ctrl-C and on every error. The same
    command goes on where a capture broke off. Then: armtwin measure.

    Example: armtwin capture --bench bench.toml --plan paper --out recordings/first
    """
    if bench == EMULATED:
        with EmulatedBench(speed=speed) as emulated:
            setup = read_bench(emulated.bench_file)
            capture(setup, plan, out, hold_out, emulated.hang)
    elif speed != 1.0:
        raise InputError("--speed: a real bench goes at its own speed; leave it out, or use --bench emulated")
    else:
        capture(read_bench(Path(bench)), plan, out, hold_out, None)


def capture(
    setup: BenchSetup, plan_name: str, out: Path, hold_out: list[str] | None, change_payload: ChangePayload | None
) -> None:
    """Run a capture; `change_payload` hangs a mass at the tip, a person is asked to where it is None."""
    plan = load_plan(plan_name, setup.arm)
    file = plan_name if plan_name == "paper" else Path(plan_name).name
    setup.limits.check_plan(plan, file)
    held_out = _held_out(plan, plan_name, hold_out)
    if change_payload is None and plan.payload_kg.any() and not sys.stdin.isatty():
        raise InputError(f"{file}: column 'payload_kg' changes, which needs a person at the terminal to hang the mass")
    check_out_folder(out)
    recording = CaptureFolder(out, setup.arm, setup.camera, setup.arm_plane_z_mm, setup.servo_map, plan)
    recording.check()
    try:
        if recording.done < len(plan):
            _run(setup, recording, change_payload or _ask_for_payload)
        recording.finish(held_out)
    finally:
        recording.close()
    typer.echo(f"{len(plan)} poses in {out}; next: armtwin measure {out} --out {out}")


def _run(setup: BenchSetup, recording: CaptureFolder, change_payload: ChangePayload) -> None:
    finder = marker_finder(setup.arm, setup.camera, setup.arm_plane_z_mm)
    console = Console(stderr=True)
    total = len(recording.plan)
    with ended_as_by_ctrl_c(), Progress(console=console, transient=True, disable=not console.is_terminal) as progress:
        bar = progress.add_task("poses", total=total, completed=recording.done)
        bench = HardwareBench(setup, finder)
        try:
            with bench:
                recording.open()  # only now: a port that is missing leaves no folder behind
                for note in bench.webcam.notes:
                    console.print(f"armtwin: {note}", highlight=False, markup=False, soft_wrap=True)
                run_capture(bench, recording, lambda done, _: progress.update(bar, completed=done), change_payload)
        except JobError as error:
            servos = "the servos are detached" if bench.detached else _UNHEARD
            raise JobError(
                f"{error}; {servos}; {recording.done} of {total} poses are kept: run the same command again to go on"
            ) from None


def _held_out(plan: Plan, plan_name: str, hold_out: list[str] | None) -> tuple[str, ...]:
    if hold_out is None:
        return _PAPER_HELD_OUT if plan_name == "paper" else ()
    names = {str(name) for name in plan.trajectory}
    for name in hold_out:
        if name not in names:
            raise InputError(f"--hold-out: the plan has no trajectory '{name}'; it has {', '.join(sorted(names))}")
    return tuple(hold_out)


def _ask_for_payload(payload_kg: float) -> None:
    what = f"Hang {1000 * payload_kg:g} g at the tip" if payload_kg else "Take the mass off the tip"
    typer.prompt(f"{what}, hands off, then press Enter", default="", show_default=False, err=True)
