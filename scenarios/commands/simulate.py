"""`armtwin simulate`: a twin run through a plan, as a recording."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import Progress

from armtwin.models.arm import Arm
from armtwin.models.errors import InputError
from armtwin.models.moving_twin import is_moving_twin, read_moving_twin
from armtwin.models.plan import Plan, read_plan
from armtwin.models.recordings.moving_writer import write_moving_recording
from armtwin.models.twin import read_twin
from armtwin.scenarios.commands.outputs import check_out_folder
from armtwin.scenarios.plans import load_plan
from armtwin.scenarios.twins.moving_simulation import RATE_HZ, simulate_moving
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
    rate: Annotated[
        float | None,
        typer.Option("--rate", metavar="HZ", min=1.0, max=1000.0, help=f"Of a moving arm's commands; {RATE_HZ:g}."),
    ] = None,
    model: Annotated[
        Path | None, typer.Option("--model", metavar="ARM.xml", help="The model of a moving twin's arm.")
    ] = None,
) -> None:
    """Run a twin through a plan in MuJoCo and write what its bench would record; of a moving arm's twin, its log.

    Example: armtwin simulate out/paper/diagnosis/twin.toml paper --out simulated
    """
    check_out_folder(out)
    if out.exists() and any(out.iterdir()):
        raise InputError(f"--out {out}: is not empty; name a folder that does not exist yet")
    if is_moving_twin(twin):
        if frames:
            raise InputError("--frames: pictures are taken of poses at rest; this is a moving arm's twin")
        _simulate_moving(twin, plan, out, rate, noise, seed, tuple(hold_out or ()), model)
        return
    if rate is not None or model is not None:
        raise InputError(f"--{'model' if rate is None else 'rate'}: it is for a moving arm's twin; leave it out")
    found = read_twin(twin)
    wanted = load_plan(plan, found.arm)
    _check_held_out(wanted, hold_out or ())
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


def _simulate_moving(
    twin: Path,
    plan: str,
    out: Path,
    rate: float | None,
    noise: float | None,
    seed: int,
    held_out: tuple[str, ...],
    model: Path | None,
) -> None:
    found = read_moving_twin(twin, model)
    arm = found.declared
    wanted = load_plan(plan, arm) if isinstance(arm, Arm) else read_plan(Path(plan), arm.n_joints)
    _check_held_out(wanted, held_out)
    log = simulate_moving(found, wanted, rate_hz=rate or RATE_HZ, noise_rad=noise, seed=seed, held_out=held_out)
    write_moving_recording(out, log)
    typer.echo(f"{len(log)} rows of the moving arm in {out}; next: armtwin diagnose {out} --out diagnosed")


def _check_held_out(plan: Plan, held_out: Sequence[str]) -> None:
    names = {str(name) for name in plan.trajectory}
    for name in held_out:
        if name not in names:
            raise InputError(f"--hold-out: the plan has no trajectory '{name}'; it has {', '.join(sorted(names))}")
