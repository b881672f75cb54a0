"""A moving recording's diagnosis from the folder to the files."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

from rich.console import Console
from rich.table import Table
from rich.text import Text

from armtwin.calib.motion.diagnosis import MotionDiagnosis, diagnose_motion
from armtwin.calib.motion.experiment import propose_motion
from armtwin.models.atomic import write_json, write_text
from armtwin.models.plan import write_plan
from armtwin.models.recordings.moving import ModelArm
from armtwin.models.recordings.moving_reader import read_moving
from armtwin.scenarios.diagnosis.files import written_together
from armtwin.scenarios.motion.notes import notes
from armtwin.scenarios.motion.report import motion_page
from armtwin.scenarios.motion.resimulate import Resimulated
from armtwin.scenarios.motion.table import motion_table
from armtwin.scenarios.motion.twin import motion_twin_text
from armtwin.scenarios.motion.words import NEXT_PLAN, gain, headline, missed, parameter_words, what_next, where


def report_motion(folder: Path, tell: Callable[[str], None] = lambda _: None) -> MotionDiagnosis:
    """Read a recording of a moving arm and diagnose it; raises `RecordingError`."""
    return diagnose_motion(read_moving(folder), tell)


def write_motion(folder: Path, name: str, found: MotionDiagnosis, again: Resimulated | None) -> None:
    """Write diagnosis.json, report.html and twin.toml, and the arm's model where it has one; all or none of them."""
    proposed = propose_motion(found)
    with written_together(folder) as aside:
        write_json(aside / "diagnosis.json", motion_table(found, proposed))
        write_text(aside / "report.html", motion_page(name, found, again, proposed))
        if proposed is not None:
            write_plan(aside / NEXT_PLAN, proposed.plan)
        write_text(aside / "twin.toml", motion_twin_text(found, headline(found)))
        if isinstance(found.recording.arm, ModelArm):  # the twin names the file beside it
            shutil.copyfile(found.recording.arm.model, aside / found.recording.arm.model.name)
    if proposed is None:  # what an earlier diagnosis proposed is no advice any more
        (folder / NEXT_PLAN).unlink(missing_ok=True)


def print_motion(console: Console, found: MotionDiagnosis, again: Resimulated | None) -> None:
    """Print the whole of it on a screen, joint by joint."""
    for fault in found.set_up:
        console.print(Text(f"SET-UP  {fault.said}: {fault.remedy}", style="bold"))
    if found.set_up:
        console.print(Text("What follows is of the recording without it.", style="bold"))
    console.print(Text(f"{found.verdict.upper()}  {headline(found)}", style="bold"))
    for cause in sorted(found.causes, key=lambda one: (one.joint or 0, -one.explained_percent)):
        share = f"explains {cause.explained_percent:.1f} %" if not cause.rows else f"in {len(cause.rows)} rows"
        console.print(Text(f"{cause.effect}, {where(found, cause)}: {share}", style="cyan"))
        grid = Table.grid(padding=(0, 2))
        for key, one in cause.parameters.items():
            value, interval = parameter_words(key, one)
            grid.add_row(f"  {key}", value, "" if interval == "–" else f"95 %: {interval}")
        for other in cause.equivalents:
            grid.add_row(f"  or {other}", "as well")
        console.print(grid)
    next_line = what_next(found, propose_motion(found))
    for line in (gain(found), missed(found, again), next_line, *(f"Note: {note}" for note in notes(found))):
        console.print(Text(line))
