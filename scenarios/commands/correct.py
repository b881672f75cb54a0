"""`armtwin correct`: commands that bring the arm where a plan wants it, through its extended twin."""

from __future__ import annotations

import csv
import io
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

from armtwin.hardware.bench.bench_file import BenchSetup, read_bench
from armtwin.models import atomic
from armtwin.models.errors import InputError
from armtwin.models.plan import write_plan
from armtwin.models.twin import read_twin
from armtwin.models.wanted_path import wanted_path
from armtwin.scenarios.twins.correction import Correction, correct

_MOST_LINES = 10


def correct_command(
    twin: Annotated[Path, typer.Argument(metavar="TWIN", help="twin.toml, as armtwin diagnose writes it.")],
    plan: Annotated[
        str,
        typer.Argument(metavar="PLAN.csv", help="theta1_cmd_rad, … or x_mm, y_mm[, theta_F_rad]; or 'paper'."),
    ],
    out: Annotated[Path, typer.Option("--out", metavar="CORRECTED.csv", help="The commands that go there: a plan.")],
    pulses: Annotated[
        Path | None,
        typer.Option("--pulses", metavar="BENCH.toml", help="Also write pulse widths, by this bench's servos."),
    ] = None,
) -> None:
    """Correct a plan of your own: commands that bring the arm where the plan wants it, and the error to expect.

    The twin is run through the plan in MuJoCo until nothing moves the commands any more. Points out of reach are named
    and left out. With --pulses CORRECTED_pulses.csv holds whole microseconds for each servo of the board.

    Example: armtwin correct out/paper/diagnosis/twin.toml paper --out corrected.csv
    """
    found = read_twin(twin)
    bench = None if pulses is None else read_bench(pulses)
    if bench is not None and bench.arm.n_joints != found.arm.n_joints:
        joints = f"{bench.arm.n_joints} joints, the twin {found.arm.n_joints}"
        raise InputError(f"{pulses}: the bench has {joints}; give the bench that the twin was measured on")
    correction = correct(found, wanted_path(plan, found.arm))
    if bench is not None:
        bench.limits.check_plan(correction.plan, out.name)
        atomic.write_text(pulses_beside(out), pulses_csv(correction, bench))
    write_plan(out, correction.plan)
    _print(Console(highlight=False), correction)
    typer.echo(f"{len(correction.rows)} commands written to {out}" + _also(out, bench))


def pulses_beside(out: Path) -> Path:
    """Return the file of the pulses beside a corrected plan."""
    return out.with_name(f"{out.stem}_pulses.csv")


def pulses_csv(correction: Correction, bench: BenchSetup) -> str:
    """Return whole microseconds for each servo of the board, in its order, one row a command."""
    pulses = np.rint(bench.servo_map.pulses_us(correction.plan.q_cmd)).astype(int)
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(["trajectory", *(f"servo{number + 1}_us" for number in range(pulses.shape[1]))])
    for name, row in zip(correction.plan.trajectory, pulses, strict=True):
        writer.writerow([str(name), *map(str, row)])
    return out.getvalue()


def _also(out: Path, bench: BenchSetup | None) -> str:
    return "" if bench is None else f", pulses to {pulses_beside(out)}"


def _print(console: Console, correction: Correction) -> None:
    table = Table("trajectory", "poses", "tip error before", "expected after", "worst after")
    for name in dict.fromkeys(str(name) for name in correction.plan.trajectory):
        rows = correction.plan.trajectory == name
        before, after = correction.before_mm[rows], correction.after_mm[rows]
        cells = (f"{_rms(before):.3f} mm", f"{_rms(after):.3f} mm", f"{after.max():.3f} mm")
        table.add_row(name, str(int(rows.sum())), *cells)
    console.print(table)
    if correction.before_rad is not None and correction.after_rad is not None:
        before_deg, after_deg = (np.degrees(values.max()) for values in (correction.before_rad, correction.after_rad))
        console.print(f"worst joint: {before_deg:.3f}° before, {after_deg:.3f}° expected after")
    for place, missing in correction.out_of_reach[:_MOST_LINES]:
        console.print(f"out of reach, left out: {place}, {missing:.1f} mm away")
    if len(correction.out_of_reach) > _MOST_LINES:
        console.print(f"… and {len(correction.out_of_reach) - _MOST_LINES} more")
    for note in correction.notes:
        console.print(f"note: {note}")


def _rms(values: NDArray[np.float64]) -> float:
    return float(np.sqrt(np.mean(values**2)))
