"""`armtwin sweep`: thousands of sealed worlds on the cores of this machine or of many."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from armtwin.models import atomic
from armtwin.models.errors import InputError
from armtwin.scenarios.commands.outputs import only_results


def sweep_command(
    sweep: Annotated[Path, typer.Argument(metavar="SWEEP.toml", help="Factors to be crossed, and worlds a cell.")],
    out: Annotated[Path, typer.Option("--out", help="Folder for the results; one broken off there is gone on with.")],
    scheduler: Annotated[
        str | None,
        typer.Option("--scheduler", metavar="ADDRESS", help="A Dask scheduler that exists, such as tcp://host:8786."),
    ] = None,
    workers: Annotated[
        int | None, typer.Option("--workers", min=1, max=256, help="Processes here; as many as cores unless given.")
    ] = None,
    at_most: Annotated[
        int | None,
        typer.Option("--at-most", min=1, help="Make so many worlds now; the same command goes on from there."),
    ] = None,
    with_power: Annotated[
        bool,
        typer.Option("--with-power", help="Hold armtwin power against the cells that have a plan."),
    ] = False,
    world: Annotated[
        str | None,
        typer.Option("--world", metavar="CELL/TRIAL", help="Only make one world again, as a recording with its truth."),
    ] = None,
) -> None:
    """Hide effects of many sizes in many worlds, diagnose each, and say from which size on each effect is found.

    Writes DIR/results.parquet (a row a world), costs.parquet, sizes.json and report.html. Needs armtwin[sweep].

    Example: armtwin sweep sweep.toml --out out/sweep
    """
    try:
        from armtwin.scenarios.sweeps.sweep import sweep as run_sweep
    except ModuleNotFoundError as error:
        raise InputError(f"armtwin sweep: {error.name} is not installed; pip install 'armtwin[sweep]'") from None
    from armtwin.scenarios.sweeps.again import make_again
    from armtwin.scenarios.sweeps.comparison import hold
    from armtwin.scenarios.sweeps.page import sweep_page
    from armtwin.scenarios.sweeps.summary import sizes_table, summaries
    from armtwin.scenarios.sweeps.table import read_sweep

    table = read_sweep(sweep)
    if world is not None:
        typer.echo(f"World {world} written to {make_again(table, out, world)}")
        return
    console = Console(stderr=True)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with (
        only_results(out),
        Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as progress,
    ):
        bar = progress.add_task("worlds", total=None)
        done = run_sweep(
            table,
            out,
            scheduler=scheduler,
            workers=workers,
            at_most=at_most,
            progress=lambda count, most: progress.update(bar, completed=count, total=most),
            begun=lambda page: progress.console.print(f"What runs where: {page}", markup=False),
        )
        cells = summaries(done.placings.values(), done.rows, table.trials)
        atomic.write_json(out / "sizes.json", sizes_table(cells, done.rows))
        bar = progress.add_task("power", total=None, visible=with_power)
        held = (
            hold(cells, workers or 2, lambda k, of: progress.update(bar, completed=k, total=of)) if with_power else []
        )
        atomic.write_text(out / "report.html", sweep_page(f"Sweep {sweep.stem}", cells, held, done.rows))
    typer.echo(f"{len(done.rows)} worlds in {out / 'results.parquet'}; report written to {out / 'report.html'}")
