"""`armtwin score`: how often the diagnosis is right on sealed worlds."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.progress import Progress

from armtwin.models import atomic
from armtwin.models.errors import JobError
from armtwin.scenarios.commands.own_effects import OwnEffects, register_own
from armtwin.scenarios.commands.score_logs import score_logs
from armtwin.scenarios.commands.score_tables import print_confusion, print_rates
from armtwin.scenarios.scoring.judge import Judgement, label
from armtwin.scenarios.scoring.scoring import Score, score, score_table
from armtwin.scenarios.scoring.sealing import is_moving

_CONSIDERED = 3


def score_command(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Folder that armtwin seal wrote.")],
    jobs: Annotated[int, typer.Option("--jobs", min=1, max=64, help="Processes at a time.")] = 2,
    effects: OwnEffects = None,
) -> None:
    """Diagnose the sealed worlds of DIR and hold the answers against the truth.

    Each world's outcome is kept in DIR/score, so that a killed run is gone on with; a change of the diagnosis' code
    makes them anew. The whole score is written to DIR/score.json.

    Example: armtwin score out/sealed --jobs 2
    """
    register_own(effects)
    if is_moving(folder):
        score_logs(folder, jobs)
        return
    console = Console(stderr=True)
    with Progress(console=console, transient=True, disable=not console.is_terminal) as progress:
        bar = progress.add_task("diagnosing worlds", total=None)
        result = score(folder, jobs, lambda done, total: progress.update(bar, completed=done, total=total))
    table = score_table(result)
    atomic.write_json(folder / "score.json", table)
    _print(Console(highlight=False, soft_wrap=True), result, table)
    typer.echo(f"Written to {folder / 'score.json'}")
    if result.broken:
        raise JobError(f"{len(result.broken)} of {len(result.truths)} worlds could not be diagnosed, see above")


def _print(console: Console, result: Score, table: dict[str, Any]) -> None:
    print_confusion(console, table["confusion"])
    _print_failures(console, result)
    _print_coverage(console, result, table)
    print_rates(console, table)


def _print_failures(console: Console, result: Score) -> None:
    console.print("Not right", style="bold")
    for name, judgement in result.judgements.items():
        if not judgement.right or judgement.site_right < judgement.sited:
            for line in failure_lines(name, judgement, result.truths[name], result.outcomes[name]):
                console.print(line, markup=False)
    for name, error in result.broken.items():
        console.print(f"  {name} broke down: {error}", markup=False)


def failure_lines(name: str, judgement: Judgement, truth: Any, outcome: Any) -> list[str]:
    """Say of a world that was not answered rightly what is true, what was said and what came near."""
    moved = " + ".join(f"{effect['moved_noises']:.1f}" for effect in truth["effects"])
    left = outcome["remaining"] / outcome["excess"] if outcome["excess"] else 0.0
    hidden = "; ".join(f"{label(e)} {_short(e['parameters'])}" for e in truth["effects"])
    lines = [
        f"  {name} {judgement.kind}: is {hidden or 'nothing'} (moves {moved or 0} noises, {truth['n_poses']} poses, "
        f"noise {truth['noise_px']:.3f}), said {outcome['verdict']}: {judgement.said}",
        f"       excess {outcome['excess']:.0f}, left {left:.1%}, "
        f"structure: {', '.join(outcome['structure']) or 'none'}",
    ]
    said = [*outcome["causes"], *outcome["suspects"]]
    if said:
        lines.append(
            "       causes: "
            + "; ".join(f"{label(c)} {c['explained_percent']:.1f} % {_values(c['parameters'])}" for c in said)
        )
    nearest = outcome["considered"][:_CONSIDERED]
    if nearest:
        base = outcome["deviance"]["final"]
        lines.append("       next: " + "; ".join(f"{c['label']} {c['score'] - base:+.0f}" for c in nearest))
    return lines


def _short(parameters: dict[str, Any]) -> str:
    return " ".join(f"{k}={v:.4g}" if isinstance(v, float) else f"{k}={v}" for k, v in parameters.items())


def _values(parameters: dict[str, Any]) -> str:
    return " ".join(f"{k}={v['value']:.4g}±{v['std']:.2g}" for k, v in parameters.items() if v["std"] is not None)


def _print_coverage(console: Console, result: Score, table: dict[str, Any]) -> None:
    console.print(
        "Intervals that missed: inside / all, and by how many standard deviations in which world", style="bold"
    )
    for name, (inside, total) in table["coverage_by_parameter"].items():
        outside = {w: j.misses[name] for w, j in result.judgements.items() if not j.covered.get(name, True)}
        if outside:
            where = ", ".join(f"{world} {miss:+.1f}" for world, miss in outside.items())
            console.print(f"  {name} {inside}/{total}: {where}", markup=False)
    inside, total = table["geometry_coverage"]
    console.print(f"  geometry of rightly answered worlds: {inside}/{total}")
