"""`armtwin import`: other people's logs as recordings."""

from __future__ import annotations

import sys
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Literal

import typer
from rich.console import Console
from rich.table import Table

from armtwin.models import atomic
from armtwin.models.csv_table import CsvTable
from armtwin.models.errors import InputError
from armtwin.models.importers.csv_log import log_of, proposed_mapping, read_tables, without_a_unit
from armtwin.models.importers.lerobot import read_lerobot
from armtwin.models.importers.log import JointLog, joined
from armtwin.models.importers.mapping import AngleColumn, Mapping, mapping_text, read_mapping, unknown_units
from armtwin.models.importers.mcap_bag import read_mcap
from armtwin.models.importers.sage import read_sage
from armtwin.models.importers.writing import write_import
from armtwin.scenarios.commands.outputs import check_out_folder


class Kind(StrEnum):
    """Whose format it is."""

    CSV = "csv"
    LEROBOT = "lerobot"
    SAGE = "sage"
    MCAP = "mcap"


class Unit(StrEnum):
    """What numbers are whose unit the source does not say."""

    RAD = "rad"
    DEG = "deg"
    RANGE = "range"
    COUNTS = "counts"


def import_command(
    kind: Annotated[Kind, typer.Argument(metavar="KIND", help="csv, lerobot, sage or mcap.")],
    source: Annotated[
        Path,
        typer.Argument(
            metavar="SOURCE", help="A file (csv, mcap) or a folder (lerobot, sage; csv: of files, each a motion)."
        ),
    ],
    out: Annotated[Path, typer.Option("--out", metavar="RECORDING", help="Recording folder to make; must not exist.")],
    arm: Annotated[
        Path | None, typer.Option("--arm", metavar="FILE", help="arm.toml, twin.toml, or the arm's .xml or .urdf.")
    ] = None,
    joints: Annotated[str | None, typer.Option("--joints", metavar="A,B,…", help="Only these, in this order.")] = None,
    mapping: Annotated[
        Path | None, typer.Option("--mapping", metavar="FILE", help="csv: which column is what, as proposed or mended.")
    ] = None,
    yes: Annotated[bool, typer.Option("--yes", help="csv: use the proposed mapping without asking.")] = False,
    unit: Annotated[Unit | None, typer.Option("--unit", help="csv, lerobot: of what says none.")] = None,
    calibration: Annotated[
        Path | None, typer.Option("--calibration", metavar="FILE.json", help="lerobot: the robot's calibration.")
    ] = None,
    episodes: Annotated[str | None, typer.Option("--episodes", metavar="0,1,…", help="lerobot: only these.")] = None,
    state_topic: Annotated[str | None, typer.Option("--state-topic", help="mcap: the measured angles.")] = None,
    command_topic: Annotated[str | None, typer.Option("--command-topic", help="mcap: the commanded ones.")] = None,
) -> None:
    """Make a recording of another program's log, and say what was taken for what.

    csv: a mapping of the columns is proposed from the header, shown, and saved as RECORDING.mapping.toml; mend it and
    give it back with --mapping. lerobot and mcap need pip install 'armtwin[import]'.

    Example: armtwin import csv log.csv --out recordings/log --yes
    """
    check_out_folder(out)
    if out.exists() and any(out.iterdir()):
        raise InputError(f"--out {out}: is not empty; name a folder that does not exist yet")
    names = None if joints is None else [name.strip() for name in joints.split(",")]
    if kind is Kind.CSV:
        tables = read_tables(source)
        chosen = read_mapping(mapping) if mapping is not None else _agreed(tables[0], unit, out, yes)
        log = joined([log_of(table, chosen) for table in tables]).chosen(names)
    elif kind is Kind.LEROBOT:
        log = read_lerobot(source, _of_lerobot(unit), calibration, _numbers(episodes)).chosen(names)
    elif kind is Kind.SAGE:
        log = read_sage(source, names)
    else:
        log = read_mcap(source, state_topic, command_topic).chosen(names)
    notes = write_import(out, log, arm)
    for note in (*log.notes, *notes):
        typer.echo(f"  {note}")
    typer.echo(f"{_said(log, out)}; next: armtwin diagnose {out} --out diagnosed")


def _of_lerobot(unit: Unit | None) -> Literal["deg", "range", "counts"] | None:
    if unit is Unit.RAD:
        raise InputError("--unit: no LeRobot data set is in rad; deg, range or counts are wanted")
    known: dict[Unit, Literal["deg", "range", "counts"]] = {
        Unit.DEG: "deg",
        Unit.RANGE: "range",
        Unit.COUNTS: "counts",
    }
    return None if unit is None else known[unit]


def _agreed(source: CsvTable, unit: Unit | None, out: Path, yes: bool) -> Mapping:
    """Show and save the proposal; return it where a person agrees, raise `InputError` where it is not complete."""
    if unit is Unit.RANGE:
        raise InputError("--unit: range is LeRobot's; rad, deg or counts are wanted")
    proposed = proposed_mapping(source, None if unit is None else unit.value)
    saved = out.with_name(f"{out.name}.mapping.toml")
    table = Table("joint", "commanded", "measured", title=f"proposed: {proposed.motion}", title_justify="left")
    for joint in proposed.joints:
        cells = (f"{one.column} [{_said_unit(one)}]" for one in (joint.command, joint.measured))
        table.add_row(joint.name, *(cell.replace("[", r"\[") for cell in cells))
    console = Console(highlight=False)
    console.print(table)
    if proposed.time is not None:
        console.print(f"time: {proposed.time.column} ({proposed.time.unit})", markup=False)
    atomic.write_text(saved, mapping_text(proposed))
    typer.echo(f"saved as {saved}")
    unknown = unknown_units(proposed)
    if unknown:
        raise InputError(
            f"{saved}: the unit of column '{unknown[0]}' is not told; write it there and give --mapping {saved}, or "
            "give --unit"
        )
    by_values = [name for name in without_a_unit(source) if unit is None and name not in unknown]
    if by_values:
        typer.echo(f"by their values, not their names, told the units of: {', '.join(by_values)}")
    if not yes and not (sys.stdin.isatty() and typer.confirm("Use it?", err=True)):
        raise InputError(f"{saved}: not used yet; give --yes, or mend it and give --mapping {saved}")
    return proposed


def _said_unit(one: AngleColumn) -> str:
    middle = "" if one.counts_per_turn is None else f", {one.counts_per_turn:g} a turn from {one.offset:g}"
    return f"{one.unit}{middle}"


def _numbers(text: str | None) -> list[int] | None:
    if text is None:
        return None
    words = [word.strip() for word in text.split(",")]
    if not all(word.isdecimal() and len(word) < 9 for word in words):
        raise InputError(f"--episodes: found '{text[:40]}', whole numbers with commas between are wanted")
    return [int(word) for word in words]


def _said(log: JointLog, out: Path) -> str:
    runs = len(set(log.trajectory.tolist()))
    what = "samples of a moving arm" if log.motion == "moving" else "poses"
    return f"{len(log)} {what}, {len(log.joints)} joints, {runs} trajectories in {out}"
