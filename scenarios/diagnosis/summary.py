"""The diagnosis in the terminal: verdict, causes, gain, what to do next."""

from __future__ import annotations

from rich.console import Console
from rich.table import Table
from rich.text import Text

from armtwin.scenarios.diagnosis.looks import remainder_in_words
from armtwin.scenarios.diagnosis.sections import DiagnosisReport
from armtwin.scenarios.diagnosis.words import gain, headline, missed, parameter_rows, site_words, what_next


def print_summary(console: Console, report: DiagnosisReport) -> None:
    """Print the whole of it on a screen."""
    diagnosis = report.diagnosis
    for line in report.screened.sentences:
        console.print(Text(f"SET-UP  {line}", style="bold"))
    if report.screened.errors:
        console.print(Text("What follows is of the recording without it.", style="bold"))
    console.print(Text(f"{diagnosis.verdict.upper()}  {headline(diagnosis)}", style="bold"))
    if diagnosis.verdict == "unknown":
        console.print(Text(remainder_in_words(diagnosis, report.screened.recording.sample)))
    if diagnosis.suspects:
        console.print(Text("Nearest, and not proven:"))
    for cause in diagnosis.causes or diagnosis.suspects:
        where, share = site_words(cause), f"{cause.explained_percent:.1f} %"
        console.print(Text(f"{cause.active.effect.name}, {where}: explains {share}", style="cyan"))
        table = Table.grid(padding=(0, 2))
        for name, value, interval in parameter_rows(cause, diagnosis):
            table.add_row(f"  {name}", value, "" if interval == "–" else f"95 %: {interval}")
        for other in cause.equivalents:
            table.add_row(f"  or {other.label}", "as well")
        console.print(table)
    for line in (
        gain(diagnosis),
        missed(report.resimulation),
        what_next(diagnosis, report.experiment),
        *(f"Note: {note}" for note in report.notes),
    ):
        console.print(Text(line))
