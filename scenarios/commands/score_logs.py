"""`armtwin score` on logs of a moving arm."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import typer
from rich.console import Console
from rich.progress import Progress

from armtwin.models import atomic
from armtwin.models.errors import JobError
from armtwin.scenarios.commands.score_tables import print_confusion, print_rates
from armtwin.scenarios.scoring.judge import Judgement, label, name_said
from armtwin.scenarios.scoring.moving_scoring import MovingScore, moving_rates, score_moving
from armtwin.scenarios.scoring.sealing import read_truth
from armtwin.scenarios.scoring.summary import as_table, confusion, coverage_by_parameter, held_out_figures

SCHEMA = "armtwin.score/1"
_FLOORS = 1.15


def score_logs(folder: Path, jobs: int) -> None:
    """Diagnose the logs of `folder`, print the rates and write `score.json`; raises `JobError` where some broke."""
    truths = read_truth(folder)["worlds"]
    screen = Console(stderr=True)
    with Progress(console=screen, transient=True, disable=not screen.is_terminal) as progress:
        bar = progress.add_task("diagnosing logs", total=None)
        result = score_moving(folder, truths, jobs, lambda done, n: progress.update(bar, completed=done, total=n))
    table = moving_table(result)
    atomic.write_json(folder / "score.json", table)
    console = Console(highlight=False, soft_wrap=True)
    print_confusion(console, table["confusion"])
    for name, judgement in result.judgements.items():
        if not judgement.right or judgement.site_right < judgement.sited:
            console.print(f"  {name} {_told(judgement, result.truths[name])}", markup=False)
    for name, error in result.broken.items():
        console.print(f"  {name} broke down: {error}", markup=False)
    for name, (inside, of) in table["coverage_by_parameter"].items():
        if inside < of:
            outside = {w: j.misses[name] for w, j in result.judgements.items() if not j.covered.get(name, True)}
            where = ", ".join(f"{log} {miss:+.1f}" for log, miss in outside.items())
            console.print(f"  {name} {inside}/{of} inside its interval; standard deviations off: {where}", markup=False)
    print_rates(console, table, "logs", _FLOORS)
    typer.echo(f"Written to {folder / 'score.json'}")
    if result.broken:
        raise JobError(f"{len(result.broken)} of {len(result.truths)} logs could not be diagnosed, see above")


def moving_table(result: MovingScore) -> dict[str, Any]:
    """Return the content of `score.json`."""
    judged = list(result.judgements.values())
    seconds = [judgement.seconds for judgement in judged]
    return {
        "schema": SCHEMA,
        "motion": "moving",
        "worlds": len(result.truths),
        "rates": {name: as_table(rate) for name, rate in moving_rates(judged).items()},
        "held_out_over_floor": held_out_figures(judged),
        "coverage_by_parameter": coverage_by_parameter(judged),
        "confusion": confusion([_pair(result, name) for name in result.outcomes]),
        "seconds": {
            name: float(np.quantile(seconds, share)) if seconds else None
            for name, share in (("median", 0.5), ("p90", 0.9), ("most", 1.0))
        },
        "judgements": {name: asdict(judgement) for name, judgement in result.judgements.items()},
        "broken": dict(result.broken),
    }


def _pair(result: MovingScore, name: str) -> tuple[str, str]:
    truth, outcome = result.truths[name], result.outcomes[name]
    true = " + ".join(sorted(effect["effect"] for effect in truth["effects"])) or "nothing"
    said = name_said(outcome["verdict"], outcome["causes"])
    return f"({true})" if truth["kind"] == "uncatalogued" else true, said


def _told(judgement: Judgement, truth: Any) -> str:
    """Say of a log that was not answered rightly what is hidden and what was said."""
    hidden = "; ".join(
        f"{label(e)} {e['moved_noises']:.0f} noises "
        + " ".join(f"{k}={v:.4g}" for k, v in e["parameters"].items() if isinstance(v, int | float))
        for e in truth["effects"]
    )
    return f"{judgement.kind}: is {hidden or 'nothing'}; said {judgement.said}"
