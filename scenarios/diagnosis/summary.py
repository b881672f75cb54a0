"""The diagnosis in the terminal: verdict, causes, gain, what to do next."""

from __future__ import annotations

from collections.abc import Sequence

from rich.console import Console
from rich.table import Table
from rich.text import Text

from calib.diagnosis.diagnosis import Diagnosis
from scenarios.diagnosis.next_experiment import NextExperiment
from scenarios.diagnosis.resimulate import Resimulation
from scenarios.diagnosis.words import gain, headline, parameter_rows, site_words, what_next


def print_summary(
    console: Console,
    diagnosis: Diagnosis,
    again: Resimulation,
    experiment: NextExperiment | None,
    notes: Sequence[str],
) -> None:
    """Print the whole of it on a screen."""
    console.print(Text(f"{diagnosis.verdict.upper()}  {headline(diagnosis)}", style="bold"))
    causes = diagnosis.causes or diagnosis.suspects
    if causes:
        table = Table(title=None if diagnosis.causes else "Nearest, not proven")
        for heading in ("effect", "at", "explains", "parameter", "value", "95 % interval"):
            table.add_column(heading, justify="right" if heading in ("explains", "value", "95 % interval") else "left")
        for cause in causes:
            rows = parameter_rows(cause, diagnosis) or [("", "", "")]
            for number, row in enumerate(rows):
                first = number == 0
                table.add_row(
                    cause.active.effect.name if first else "",
                    site_words(cause) if first else "",
                    f"{cause.explained_percent:.1f} %" if first else "",
                    *row,
                )
            for other in cause.equivalents:
                table.add_row(Text(f"or {other.effect.name}"), str(other.site), "", "", "", "")
        console.print(table)
    for line in (
        gain(diagnosis),
        _again(again),
        what_next(diagnosis, experiment),
        *(f"Note: {note}" for note in notes),
    ):
        console.print(Text(line))


def _again(again: Resimulation) -> str:
    return (
        f"Re-simulated in MuJoCo, the extended twin misses the recording by {again.rms_mm:.3g} mm "
        f"({again.held_out_rms_mm:.3g} mm on the held-out poses)."
    )
