"""`armtwin capture --film`: the arm filmed on its way, on any bench that can."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import typer
from rich.console import Console
from rich.progress import Progress

from armtwin.hardware.capture.film import film as film_into
from armtwin.models.bench import FilmingBench
from armtwin.models.errors import InputError, JobError
from armtwin.models.plan import Plan
from armtwin.scenarios.benches.door import open_bench
from armtwin.scenarios.benches.spec import bench_spec
from armtwin.scenarios.closed_loop import PAPER_VALIDATION
from armtwin.scenarios.commands.interrupts import ended_as_by_ctrl_c
from armtwin.scenarios.commands.outputs import check_out_folder
from armtwin.scenarios.plans import load_plan

SLOWEST_HZ = 1.0
FASTEST_HZ = 200.0
# A usual webcam's pictures a second.
_USUAL_HZ = 30.0


def film_command(
    bench_name: str,
    plan_name: str,
    out: Path,
    hold_out: list[str] | None,
    *,
    film: bool,
    rate_hz: float | None,
    speed: float | None,
    token: str | None,
) -> None:
    """Stream a plan's commands and film the arm; raises `InputError` and `JobError`."""
    if not film:
        raise InputError("--rate: it is that of a film's commands; give --film as well")
    if speed not in (None, 1.0):
        raise InputError(f"--speed: {speed:g} found; a film is seen in real time, leave it out")
    bench = open_bench(bench_spec(bench_name, token=token))
    if not isinstance(bench, FilmingBench):
        raise InputError(f"--bench: a {bench.description.kind} bench takes one picture a pose and does not film")
    plan = load_plan(plan_name, bench.description.arm)
    file = plan_name if plan_name == "paper" else Path(plan_name).name
    time_s = _times(plan, file, rate_hz)
    bench.description.limits.check_plan(plan, file)
    if plan.payload_kg.any():
        raise InputError(f"{file}: column 'payload_kg': nobody hangs a mass while the arm is filmed; leave it out")
    held_out = held_out_of(plan, plan_name, hold_out)
    check_out_folder(out)
    if out.exists() and any(out.iterdir()):
        raise InputError(f"{out}: not empty; a film is made in one go, choose another --out")
    console = Console(stderr=True)
    with ended_as_by_ctrl_c(), Progress(console=console, transient=True, disable=not console.is_terminal) as progress:
        bar = progress.add_task("pictures", total=len(plan))
        try:
            with bench:
                for note in bench.notes:
                    console.print(f"armtwin: {note}", highlight=False, markup=False, soft_wrap=True)
                film_into(bench, plan, time_s, out, held_out, lambda done, _: progress.update(bar, completed=done))
        except JobError as error:
            raise JobError(f"{error}; nothing is kept: film again") from None
    typer.echo(f"{len(plan)} pictures of the moving arm in {out}; next: armtwin measure {out} --out ANGLES")


def held_out_of(plan: Plan, plan_name: str, hold_out: list[str] | None) -> tuple[str, ...]:
    """Return the trajectories to be kept for validation; raises `InputError` for one that the plan lacks."""
    if hold_out is None:
        return (PAPER_VALIDATION,) if plan_name == "paper" else ()
    names = {str(name) for name in plan.trajectory}
    for name in hold_out:
        if name not in names:
            raise InputError(f"--hold-out: the plan has no trajectory '{name}'; it has {', '.join(sorted(names))}")
    return tuple(hold_out)


def _times(plan: Plan, file: str, rate_hz: float | None) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """(N,) times of the commands: the plan's own, or one after another at the rate."""
    if plan.time_s is not None:
        if rate_hz is not None:
            raise InputError(f"--rate: {file} says in its column time_s when its commands are given; leave one out")
        return plan.time_s
    return np.arange(len(plan), dtype=float) / (_USUAL_HZ if rate_hz is None else rate_hz)
