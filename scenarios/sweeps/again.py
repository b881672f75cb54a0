"""Make one world of a sweep again, to be looked at and diagnosed by hand."""

from __future__ import annotations

from pathlib import Path

from armtwin.models import atomic
from armtwin.models.errors import InputError
from armtwin.models.recordings.writer import write_recording
from armtwin.scenarios.sweeps.journal import read_rows
from armtwin.scenarios.sweeps.table import SweepTable, cells_of
from armtwin.scenarios.sweeps.trial import Trial, draw, plan_of_cell


def make_again(table: SweepTable, out: Path, world: str) -> Path:
    """Write world `CELL/TRIAL` of the sweep in `out` as a recording, its truth beside it; return the folder.

    Raises `InputError` where the sweep has no such world.
    """
    rows = read_rows(out)
    cell, _, number = world.partition("/")
    row = rows.get((int(cell), int(number))) if cell.isdecimal() and number.isdecimal() else None
    if row is None:
        raise InputError(
            f"--world: found '{world}', which {out} does not hold; CELL/TRIAL of a finished world is wanted"
        )
    of_cell = next(c for c in cells_of(table) if c.number == row["cell"])
    sealed = draw(Trial(of_cell, row["trial"], row["size"], table.seed, plan_of_cell(of_cell)))
    folder = out / "worlds" / f"{row['cell']}-{row['trial']}"
    write_recording(folder, sealed.recording)
    atomic.write_json(folder.with_suffix(".truth.json"), sealed.truth)
    return folder
