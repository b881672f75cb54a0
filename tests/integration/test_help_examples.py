"""The example of every command's help works as typed after `make demo`, one after the other in one folder."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from armtwin.hardware.emulator import missing_packages
from armtwin.scenarios.cli import COMMANDS, build_app

EXAMPLE = re.compile(r"Example: (armtwin [^\n]+)")
# What is on a person's own table: its example shows where the name goes.
OWN = {"bench.toml", "log.csv", "sweep.toml", "CLASS.toml", "course"}
# They go on until they are stopped, and open a browser.
LASTING = {"serve", "lab open"}
EMULATED = "--bench emulated"
# The demo's files from fewer poses.
DEMO = """
schema = "armtwin.scenario/1"
title = "The demo, shortened"
board_views = 8
gauge_placements = 2
gauge_lengths_mm = [30.0]
[geometry]
length_errors_mm = [6.7, 4.6, -0.7, 1.0]
joint_errors_rad = [0.02, 0.018, 0.083]
[trajectories.circle]
kind = "circle"
radius_mm = 25
samples = 12
[trajectories.line]
kind = "line"
start_mm = [-145, 25]
end_mm = [-115, 45]
samples = 6
"""
# Those that make files stand before those that take them.
FIRST = ("seal", "correct", "simulate")


def examples() -> list[str]:
    """Return the example of every command, of each one of a family too."""
    found = []
    for name in COMMANDS:
        app = build_app(name)
        commands = [one.callback for one in app.registered_commands]
        for group in app.registered_groups:
            commands += [one.callback for one in group.typer_instance.registered_commands]
        for command in commands:
            match = EXAMPLE.search(command.__doc__ or "")
            assert match is not None, f"{name} has no example"
            found.append(match[1])
    return sorted(found, key=lambda example: example.split()[1] not in FIRST)


def is_own(example: str) -> bool:
    return any(word in OWN for word in example.split())


def lasts(example: str) -> bool:
    return any(example.startswith(f"armtwin {name}") for name in LASTING)


@pytest.mark.parametrize("example", examples())
def test_an_example_names_options_that_there_are(example: str) -> None:
    _, name, *words = shlex.split(example)
    app = build_app(name)
    called = [name, words[0]] if app.registered_groups else [name]
    told = CliRunner().invoke(app, [*called, "--help"], env={"COLUMNS": "200"}).output
    for option in (word for word in words if word.startswith("--")):
        assert option in told


@pytest.mark.slow
def test_every_example_works_as_typed_after_the_demo(tmp_path: Path) -> None:
    (tmp_path / "demo.toml").write_text(DEMO)
    shell = f'armtwin() {{ "{sys.executable}" -m armtwin "$@"; }}\n'

    def run(line: str) -> None:
        done = subprocess.run(["bash", "-c", shell + line], cwd=tmp_path, capture_output=True, text=True, timeout=3600)
        assert done.returncode == 0, f"{line}\n{done.stdout[-1000:]}\n{done.stderr[-2000:]}"

    run("armtwin run demo.toml --out out/paper")
    for example in examples():
        if is_own(example) or lasts(example) or example == "armtwin run paper --out out/paper":
            continue
        if EMULATED in example and missing_packages():
            continue
        run(example.replace("--n 50", "--n 2"))
