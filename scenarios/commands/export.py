"""`armtwin export`: a twin as a model that other tools load."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from armtwin.models.errors import InputError
from armtwin.models.export.held import Held, label
from armtwin.models.export.mjcf import export_mjcf, note_beside
from armtwin.models.export.onto_urdf import export_onto_urdf
from armtwin.models.export.urdf import export_urdf
from armtwin.models.moving_twin import is_moving_twin, read_moving_twin
from armtwin.models.twin import read_twin
from armtwin.sim.motion.export import export_moving_mjcf


def export_command(
    twin: Annotated[Path, typer.Argument(metavar="TWIN", help="twin.toml, as armtwin diagnose writes it.")],
    mjcf: Annotated[Path | None, typer.Option("--mjcf", metavar="OUT.xml", help="Write MJCF for MuJoCo.")] = None,
    urdf: Annotated[Path | None, typer.Option("--urdf", metavar="OUT.urdf", help="Write URDF.")] = None,
    onto: Annotated[
        Path | None, typer.Option("--onto", metavar="ROBOT.urdf", help="Mend this URDF instead of writing a new one.")
    ] = None,
    joints: Annotated[
        str | None, typer.Option("--joints", metavar="A,B,…", help="With --onto: the twin's joints by its names.")
    ] = None,
    tip: Annotated[str | None, typer.Option("--tip", metavar="LINK", help="With --onto: the link at the tip.")] = None,
    model: Annotated[
        Path | None, typer.Option("--model", metavar="ARM.xml", help="The model of a moving twin's arm.")
    ] = None,
) -> None:
    """Write a twin as MJCF or URDF: the calibrated geometry, and every effect that the format can hold.

    MJCF holds gaps, springs, friction and the servos; URDF holds lengths, joint zeros (in <origin>), masses, limits.
    A note beside the file, NAME.armtwin.json, says what it cannot hold.

    Example: armtwin export out/paper/diagnosis/twin.toml --mjcf arm.xml
    """
    if mjcf is None and urdf is None:
        raise InputError("give --mjcf OUT.xml or --urdf OUT.urdf")
    if (onto or joints or tip) and urdf is None:
        raise InputError("--onto, --joints and --tip mend a URDF: give --urdf OUT.urdf too")
    if (joints or tip) and onto is None:
        raise InputError("--joints and --tip name parts of a URDF: give --onto ROBOT.urdf")
    if mjcf is not None and urdf is not None and note_beside(mjcf) == note_beside(urdf):
        raise InputError(f"--mjcf and --urdf: both notes would be {note_beside(mjcf)}; give the files different names")
    if is_moving_twin(twin):
        _export_moving(twin, mjcf, urdf, model)
        return
    if model is not None:
        raise InputError("--model: it is that of a moving arm's twin; this one has its arm in it")
    found = read_twin(twin)
    if mjcf is not None:
        _tell(mjcf, export_mjcf(found, mjcf))
    if urdf is not None:
        names = None if joints is None else [name.strip() for name in joints.split(",")]
        held = export_urdf(found, urdf) if onto is None else export_onto_urdf(found, onto, urdf, names, tip)
        _tell(urdf, held)


def _export_moving(twin: Path, mjcf: Path | None, urdf: Path | None, model: Path | None) -> None:
    if urdf is not None or mjcf is None:
        raise InputError(f"{twin.name}: no URDF holds the drives of a moving arm's twin; give --mjcf OUT.xml")
    found = read_moving_twin(twin, model)
    kept = export_moving_mjcf(found.causes, found.arm, mjcf, found.zeros_rad)
    typer.echo(f"{mjcf}: the moving arm" + "".join(f", {name} ({site})" for name, site, _ in kept.held))
    for (name, site, _), recipe in kept.not_held:
        typer.echo(f"  without {name} ({site}): {recipe}")
    typer.echo(f"  what it holds, and how to make what it does not: {note_beside(mjcf)}")


def _tell(path: Path, held: Held) -> None:
    typer.echo(f"{path}: the calibrated arm" + "".join(f", {label(effect)}" for effect in held.held))
    for one in held.not_held:
        typer.echo(f"  without {label(one.effect)}, which {one.why}")
    typer.echo(f"  what it holds and what it does not: {note_beside(path)}")
