"""`armtwin diagnose`: what the twin of a recording gets wrong, why, and what naming the cause gains."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

from armtwin.models.errors import InputError
from armtwin.models.recordings.moving_reader import is_moving, read_moving
from armtwin.models.recordings.moving_writer import write_moving_recording
from armtwin.models.recordings.writer import write_recording
from armtwin.scenarios.benches.spec import KINDS, BenchSpec, bench_spec
from armtwin.scenarios.closed_loop import close_loop_on, described
from armtwin.scenarios.commands.interrupts import ended_as_by_ctrl_c
from armtwin.scenarios.commands.outputs import only_results
from armtwin.scenarios.commands.own_effects import OwnEffects, register_own
from armtwin.scenarios.diagnosis.measured import measured
from armtwin.scenarios.diagnosis.pipeline import report_on, write_report
from armtwin.scenarios.diagnosis.summary import print_summary
from armtwin.scenarios.motion.closed_loop import close_motion_loop_on
from armtwin.scenarios.motion.closed_loop import described as described_round
from armtwin.scenarios.motion.pipeline import print_motion, report_motion, write_motion
from armtwin.scenarios.motion.resimulate import resimulated


def diagnose_command(
    out: Annotated[Path, typer.Option("--out", help="Folder for diagnosis.json, report.html and twin.toml.")],
    recording: Annotated[
        Path | None,
        typer.Argument(
            metavar="RECORDING",
            help="Folder with recording.json and samples.csv; markers that are not measured yet are found in frames/.",
        ),
    ] = None,
    bench: Annotated[
        str | None,
        typer.Option(
            "--bench",
            help="Run the proposed experiments on this bench, until nothing more can be told; without RECORDING the "
            f"scenario's trajectories, or the paper's, come first. The bench: {KINDS}.",
        ),
    ] = None,
    token: Annotated[
        str | None, typer.Option("--token", envvar="ARMTWIN_TOKEN", help="What a served bench asks for.")
    ] = None,
    effects: OwnEffects = None,
    mend: Annotated[
        bool, typer.Option("--mend", help="Write the recording without the gross errors of its set-up to OUT/mended.")
    ] = False,
) -> None:
    """Name what the twin of a recording gets wrong, extend it, and measure the gain on held-out poses.

    Writes diagnosis.json (verdict, causes with intervals, gain), report.html (one file that opens offline) and
    twin.toml (the extended twin, from which the simulated bench is rebuilt); where causes tie also
    next_experiment.csv, the poses (of a moving arm the motions) that tell them apart. With --bench also recording/, the
    experiments' poses included, and experiments/, what a bench with a camera recorded.

    Example: armtwin diagnose out/paper/recordings/before --out diagnosed
    """
    if recording is not None and is_moving(recording):
        if mend:
            raise InputError(
                "--mend: gross errors of a moving arm's log are mended for its diagnosis alone; leave it out"
            )
        _diagnose_motion(recording, out, None if bench is None else bench_spec(bench, token=token))
        return
    where = None if bench is None else bench_spec(bench, token=token)
    register_own(effects)
    with ended_as_by_ctrl_c(), only_results(out), _telling() as tell:
        data = None if recording is None else measured(recording, tell)
        rounds = [] if where is None else close_loop_on(where, data, out / "experiments", tell)
        data = rounds[-1].recording if rounds else data
        if data is None:
            raise InputError("RECORDING is missing; give a recording's folder, or --bench BENCH")
        report = report_on(data, tell)
        mended = report.screened.recording if mend and report.screened.errors else None
        tell("writing the report")
        write_report(out, bench or "" if recording is None else recording.resolve().name, report)
        if rounds:
            write_recording(out / "recording", data)
        if mended is not None:
            write_recording(out / "mended", mended)
    for number, one in enumerate(rounds, start=1):
        typer.echo(f"round {number}: {described(one)}")
    print_summary(Console(), report)
    if mended is not None:
        typer.echo(f"Recording without the errors of the set-up written to {out / 'mended'}")
    typer.echo(f"Report written to {out / 'report.html'}, diagnosis.json and twin.toml beside it")


@contextmanager
def _telling() -> Iterator[Callable[[str], None]]:
    """Yield a function that shows on a terminal what is being done, and for how long."""
    columns = (SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn())
    screen = Console(stderr=True)
    with Progress(*columns, console=screen, transient=True, disable=not screen.is_terminal) as progress:
        bar = progress.add_task("reading the recording", total=None)
        yield lambda what: progress.update(bar, description=what)


def _diagnose_motion(recording: Path, out: Path, bench: BenchSpec | None) -> None:
    """Diagnose a recording of a moving arm; on a bench run the proposed motions, until nothing more can be told."""
    with ended_as_by_ctrl_c(), only_results(out), _telling() as tell:
        if bench is None:
            rounds = []
            found = report_motion(recording, tell)
        else:
            rounds = close_motion_loop_on(bench, read_moving(recording), out / "experiments", tell)
            found = rounds[-1].found
        tell("re-simulating the held-out motions with the extended twin")
        again = resimulated(found)
        tell("writing the report")
        write_motion(out, recording.resolve().name, found, again)
        if len(rounds) > 1:
            write_moving_recording(out / "recording", found.recording)
    for number, one in enumerate(rounds, start=1):
        typer.echo(described_round(number, one))
    print_motion(Console(), found, again)
    typer.echo(f"Report written to {out / 'report.html'}, diagnosis.json and twin.toml beside it")
