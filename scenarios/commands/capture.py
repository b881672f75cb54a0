"""`armtwin capture`: a recording of a plan, made by any bench."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import Progress

from armtwin.hardware.capture.capture import run_capture
from armtwin.hardware.capture.folder import CaptureFolder
from armtwin.models.bench import Bench
from armtwin.models.errors import InputError, JobError
from armtwin.scenarios.benches.door import open_bench
from armtwin.scenarios.benches.spec import KINDS, bench_spec
from armtwin.scenarios.commands.capture_film import FASTEST_HZ, SLOWEST_HZ, film_command, held_out_of
from armtwin.scenarios.commands.interrupts import ended_as_by_ctrl_c
from armtwin.scenarios.commands.outputs import check_out_folder
from armtwin.scenarios.emulated_bench import MAX_SPEED, MIN_SPEED
from armtwin.scenarios.plans import load_plan

_UNHEARD = "the board does not answer and detaches the servos itself, two seconds after it last heard the program"


def capture_command(
    bench: Annotated[str, typer.Option("--bench", help=f"The bench: {KINDS}.")],
    plan: Annotated[str, typer.Option("--plan", help="'paper', or a CSV of commands or of poses.")],
    out: Annotated[Path, typer.Option("--out", help="Recording folder; one that broke off is taken up.")],
    hold_out: Annotated[
        list[str] | None, typer.Option("--hold-out", help="Trajectory to keep for validation; may be given again.")
    ] = None,
    speed: Annotated[
        float | None,
        typer.Option("--speed", min=MIN_SPEED, max=MAX_SPEED, help="Of the emulated bench, times real time."),
    ] = None,
    film: Annotated[
        bool, typer.Option("--film", help="Stream the plan's commands and film the arm on its way: a moving recording.")
    ] = False,
    rate: Annotated[
        float | None,
        typer.Option("--rate", min=SLOWEST_HZ, max=FASTEST_HZ, help="Commands and pictures a second of a film."),
    ] = None,
    token: Annotated[
        str | None, typer.Option("--token", envvar="ARMTWIN_TOKEN", help="What a served bench asks for.")
    ] = None,
) -> None:
    """Move the arm through a plan and take a picture of every pose.

    Limits and steps of the whole plan are checked before anything moves, the arm sets out slowly from where it stands,
    each pose is on disk before the next, and the servos are detached at the end, on Ctrl-C and on every error. The same
    command goes on where a capture broke off. Then: armtwin measure.

    With --film the commands follow one another at --rate (or at the plan's own time_s) whether the arm has arrived or
    not, and every row is a picture of the arm on its way.

    Example: armtwin capture --bench simulated --plan paper --out recordings/first
    """
    if film or rate is not None:
        film_command(bench, plan, out, hold_out, film=film, rate_hz=rate, speed=speed, token=token)
        return
    ask = _ask_for_load if sys.stdin.isatty() else None
    capture(open_bench(bench_spec(bench, token=token, speed=speed), hang_by=ask), plan, out, hold_out)


def capture(bench: Bench, plan_name: str, out: Path, hold_out: list[str] | None) -> None:
    """Run a plan on a bench that is not yet connected; it is closed at the end."""
    what = bench.description
    plan = load_plan(plan_name, what.arm)
    file = plan_name if plan_name == "paper" else Path(plan_name).name
    if plan.time_s is not None:
        raise InputError(
            f"{file}: column 'time_s' gives commands their times, which --film keeps; leave it out, or film"
        )
    what.limits.check_plan(plan, file)
    held_out = held_out_of(plan, plan_name, hold_out)
    if not what.hangs_loads and plan.payload_kg.any():
        raise InputError(f"{file}: column 'payload_kg' changes, which needs a person at the terminal to hang the mass")
    check_out_folder(out)
    recording = CaptureFolder(out, what, plan, None if hold_out is None else held_out)
    recording.check()
    try:
        if recording.done < len(plan):
            _run(bench, recording)
        recording.finish(held_out)
    finally:
        recording.close()
    typer.echo(f"{len(plan)} poses in {out}; next: armtwin measure {out} --out {out}")


def _run(bench: Bench, recording: CaptureFolder) -> None:
    console = Console(stderr=True)
    total = len(recording.plan)
    with ended_as_by_ctrl_c(), Progress(console=console, transient=True, disable=not console.is_terminal) as progress:
        bar = progress.add_task("poses", total=total, completed=recording.done)
        try:
            with bench:
                recording.open(bench.clock_origin_s)  # only now: a port that is missing leaves no folder behind
                for note in bench.notes:
                    console.print(f"armtwin: {note}", highlight=False, markup=False, soft_wrap=True)
                run_capture(bench, recording, lambda done, _: progress.update(bar, completed=done))
        except JobError as error:
            servos = "the servos are detached" if bench.detached else _UNHEARD
            raise JobError(
                f"{error}; {servos}; {recording.done} of {total} poses are kept: run the same command again to go on"
            ) from None


def _ask_for_load(payload_kg: float) -> None:
    what = f"Hang {1000 * payload_kg:g} g at the tip" if payload_kg else "Take the mass off the tip"
    typer.prompt(f"{what}, hands off, then press Enter", default="", show_default=False, err=True)
