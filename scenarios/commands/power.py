"""`armtwin power`: what a plan can see, before anyone measures."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from armtwin.models import atomic
from armtwin.models.arm import nominal_arm, read_arm
from armtwin.models.camera_files import read_camera
from armtwin.models.errors import InputError
from armtwin.models.plan import write_plan
from armtwin.scenarios.commands.outputs import only_results
from armtwin.scenarios.plans import BUILT_IN, load_plan
from armtwin.scenarios.power.page import power_page
from armtwin.scenarios.power.power import Power, power, power_table
from armtwin.scenarios.power.proposal import design_section, design_table, propose, told
from armtwin.scenarios.power.setting import Setting
from armtwin.scenarios.power.words import about, known_to, label, needed, taken_for
from armtwin.sim.sealed.draw import sealing_of

_FEWEST_POSES = 12


def power_command(
    plan: Annotated[str, typer.Argument(metavar="PLAN", help=f"A plan's CSV, or {', '.join(BUILT_IN)}.")],
    out: Annotated[Path, typer.Option("--out", help="Folder for power.json and report.html.")],
    noise_px: Annotated[
        float, typer.Option("--noise-px", min=1e-3, max=50.0, help="Standard deviation of one pixel coordinate.")
    ] = 0.06,
    arm: Annotated[Path | None, typer.Option("--arm", help="Arm file; the paper's arm unless given.")] = None,
    camera: Annotated[
        Path | None, typer.Option("--camera", help="Camera file; the paper's webcam unless given.")
    ] = None,
    markers: Annotated[str | None, typer.Option("--markers", help="Letters of those looked for, as abcf.")] = None,
    effects: Annotated[str | None, typer.Option("--effects", help="Only these effects, separated by commas.")] = None,
    moving: Annotated[bool, typer.Option("--moving", help="A moving recording; not yet answered.")] = False,
    design: Annotated[
        int | None, typer.Option("--design", min=12, max=2000, help="Propose so many poses that show every fault best.")
    ] = None,
    add: Annotated[bool, typer.Option("--add", help="Add the proposed poses to PLAN instead of replacing it.")] = False,
    goal: Annotated[
        str | None, typer.Option("--goal", metavar="PATH.csv", help="Poses where the tip's error is to be small, too.")
    ] = None,
    jobs: Annotated[int, typer.Option("--jobs", min=1, max=64, help="Processes at a time.")] = 2,
) -> None:
    """Say of every fault how large it must be to be found in 90 of 100 recordings of PLAN, and what else it may seem.

    Example: armtwin power paper --noise-px 0.06 --out out/power
    """
    if moving:
        raise InputError("--moving: only settled recordings are answered yet; leave --moving out")
    if design is None and (add or goal is not None):
        raise InputError("--add and --goal say how poses are proposed: give --design N with them")
    setting = _setting(plan, noise_px, arm, camera, markers)
    path = None if goal is None else load_plan(goal, setting.drawing).q_cmd
    chosen = [name.strip() for name in effects.split(",")] if effects else []
    for name in chosen:
        sealing_of(name)
    console = Console(stderr=True)
    with only_results(out), Progress(console=console, transient=True, disable=not console.is_terminal) as progress:
        bar = progress.add_task("faults", total=None)
        result = power(
            setting,
            effects=chosen,
            jobs=jobs,
            progress=lambda done, total: progress.update(bar, completed=done, total=total),
        )
        atomic.write_json(out / "power.json", power_table(result))
        proposed = None
        if design is not None:
            bar = progress.add_task("poses", total=None)
            proposed = propose(
                result, design, path, add=add, progress=lambda k, of: progress.update(bar, completed=k, total=of)
            )
            write_plan(out / "design.csv", proposed.plan)
            atomic.write_json(out / "design.json", design_table(proposed))
        sections = () if proposed is None else (design_section(proposed, setting),)
        atomic.write_text(out / "report.html", power_page(Path(plan).stem, result, *sections))
    _print(Console(highlight=False), result)
    if proposed is not None:
        typer.echo(f"{told(proposed, setting)} They stand in {out / 'design.csv'}.")
    typer.echo(f"Report written to {out / 'report.html'}, power.json beside it")


def _setting(plan: str, noise_px: float, arm: Path | None, camera: Path | None, markers: str | None) -> Setting:
    built = None if arm is None else read_arm(arm)
    known = (built or nominal_arm()).marker_names
    names = known if markers is None else tuple(markers)
    if len(names) < 2 or len(set(names)) < len(names) or set(names) - set(known):
        raise InputError(f"--markers: found '{markers}', at least two letters of {''.join(known)} are wanted")
    poses = load_plan(plan, built or nominal_arm())
    if len(poses) < _FEWEST_POSES:
        raise InputError(f"PLAN {plan}: has {len(poses)} poses, at least {_FEWEST_POSES} are wanted")
    return Setting(poses, noise_px, names, built, None if camera is None else read_camera(camera))


def _print(console: Console, result: Power) -> None:
    table = Table(
        "fault",
        "found in 50 of 100 from",
        "in 90 of 100 from",
        "then known to",
        "at half that size it seems",
        title=about(result.setting),
    )
    for one in result.places:
        name = label(one.effect, one.site)
        if one.why_not:
            table.add_row(name, "–", "–", "", one.why_not)
            continue
        table.add_row(name, needed(one, 50), needed(one, 90), known_to(one), taken_for(one))
    console.print(table)
    for one, rival in result.inseparable:
        console.print(f"These poses do not tell {label(one.effect, one.site)} from {rival}.")
