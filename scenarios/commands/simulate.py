"""`armtwin simulate`: a twin run through a plan, as a recording."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import Progress

from armtwin.models.errors import InputError
from armtwin.models.twin import read_twin
from armtwin.scenarios.commands.outputs import check_out_folder
from armtwin.scenarios.plans import load_plan
from armtwin.scenarios.twins.simulation import NOISE_PX, NOISE_RAD, simulate, write_simulation


def simulate_command(
    twin: Annotated[Path, typer.Argument(metavar="TWIN", help="twin.toml, as armtwin diagnose writes it.")],
    plan: Annotated[str, typer.Argument(metavar="PLAN.csv", help="Commands or poses, or 'paper'.")],
    out: Annotated[Path, typer.Option("--out", metavar="RECORDING", help="Recording folder to make; must not exist.")],
    frames: Annotated[bool, typer.Option("--frames", help="Render a picture of every pose too.")] = False,
    noise: Annotated[
        float | None,
        typer.Option("--noise", min=0.0, max=100.0, help=f"px ({NOISE_PX:g} if left out), or rad ({NOISE_RAD:g})."),
    ] = None,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Of the noise.")] = 0,
    hold_out: Annotated[list[str] | None, typer.Option("--hold-out", help="Trajectory to validate on.")] = None,
) -> None:
    """Run a twin through a plan in MuJoCo and write what its bench would record.

    Example: armtwin simulate out/paper/diagnosis/twin.toml paper --out simulated
    """
    check_out_folder(out)
    if out.exists() and any(out.iterdir()):
        raise InputError(f"--out {out}: is not empty; name a folder that does not exist yet")
    found = read_twin(twin)
    wanted = load_plan(plan, found.arm)
    names = {str(name) for name in wanted.trajectory}
    for name in hold_out or ():
        if name not in names:
            raise InputError(f"--hold-out: the plan has no trajectory '{name}'; it has {', '.join(sorted(names))}")
    recording = simulate(found, wanted, noise=noise, seed=seed, held_out=tuple(hold_out or ()))
    console = Console(stderr=True)
    with Progress(console=console, transient=True, disable=not console.is_terminal) as progress:
        bar = progress.add_task("pictures", total=len(wanted) if frames else None)
        write_simulation(
            out,
            found,
            wanted,
            recording,
            frames=frames,
            seed=seed,
            progress=lambda done, _: progress.update(bar, completed=done),
        )
    typer.echo(f"{len(recording)} poses in {out}; next: armtwin diagnose {out} --out diagnosed")
