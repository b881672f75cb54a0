"""`armtwin effects`: what can be wrong, as the code knows it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.table import Table

from armtwin.models.catalogue.reference import as_markdown, injected_words, reference
from armtwin.models.catalogue.registry import effect_named, register_file
from armtwin.models.errors import InputError


def effects_command(
    name: Annotated[str | None, typer.Argument(metavar="[NAME]", help="One effect; all where it is left out.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="As JSON.")] = False,
    markdown: Annotated[bool, typer.Option("--markdown", help="As a page of the documentation.")] = False,
    effects: Annotated[
        list[Path] | None,
        typer.Option("--effects", metavar="FILE.py", help="An effect of your own (the file is run); repeatable."),
    ] = None,
) -> None:
    """List what can be wrong with an arm: meaning, parameters, units, bounds, what it is taken for, the experiment.

    Example: armtwin effects backlash
    """
    if as_json and markdown:
        raise InputError("--json and --markdown: one of them is wanted")
    for path in effects or ():
        register_file(path)
    listed = reference(None if name is None else [effect_named(name)])
    if as_json:
        typer.echo(json.dumps(listed, indent=1, ensure_ascii=False))
    elif markdown:
        typer.echo(as_markdown(listed), nl=False)
    elif name is None:
        _print_all(Console(highlight=False), listed)
    else:
        _print_one(Console(highlight=False), listed[0])


def _print_all(console: Console, listed: list[dict[str, Any]]) -> None:
    table = Table("effect", "what it is", "sits at", "parameters")
    for effect in listed:
        names = ", ".join(one["name"] for one in effect["parameters"])
        table.add_row(effect["effect"], effect["summary"], effect["where"], names)
    console.print(table)


def _print_one(console: Console, effect: dict[str, Any]) -> None:
    console.print(f"{effect['effect']}: {effect['summary']}", style="bold")
    console.print(f"sits at: {effect['where']}; acts on: {effect['stage']}")
    table = Table("parameter", "unit", "least", "most")
    for one in effect["parameters"]:
        low, high = one["bounds"] or ("", "")
        table.add_row(one["name"], one["unit"] or "1", f"{low:.4g}", f"{high:.4g}")
    if effect["parameters"]:
        console.print(table)
    console.print(f"in a scenario or a twin: {injected_words(effect)}", markup=False)
    console.print(f"taken for: {', '.join(effect['confused_with']) or 'nothing'}")
    console.print(f"told apart by: {effect['experiment']}")
