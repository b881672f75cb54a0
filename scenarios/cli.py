"""The command line: one app, its commands imported only when they are called for."""

from __future__ import annotations

import importlib
import sys

import typer
from rich.console import Console

from models.errors import ArmtwinError

# Command -> module and function under scenarios/commands.
COMMANDS = {
    "run": "run:run_command",
    "capture": "capture:capture_command",
    "calibrate-camera": "calibrate_camera:calibrate_camera_command",
    "measure": "measure:measure_command",
    "calibrate": "calibrate:calibrate_command",
    "diagnose": "diagnose:diagnose_command",
    "doctor": "doctor:doctor_command",
    "targets": "targets:targets_command",
    "bench-check": "bench_check:bench_check_command",
    "seal": "seal:seal_command",
    "score": "score:score_command",
}
# What a shell reports for a program that was ended by Ctrl-C: 128 + SIGINT.
_INTERRUPTED = 130


def build_app(wanted: str | None = None) -> typer.Typer:
    """Return the app; with the name of one command only that one is imported, which keeps the start fast."""
    app = typer.Typer(name="armtwin", no_args_is_help=True, add_completion=False, pretty_exceptions_enable=False)
    app.callback(help="A simulation-first digital twin of a planar servo arm watched by one webcam.")(_nothing)
    for name in [wanted] if wanted in COMMANDS else list(COMMANDS):
        module, function = COMMANDS[name].split(":")
        command = getattr(importlib.import_module(f"scenarios.commands.{module}"), function)
        app.command(name, no_args_is_help=False)(command)
    return app


def main(arguments: list[str] | None = None) -> None:
    """Run the command line and leave with 0 done, 1 the job failed, 2 the input is wrong, 130 interrupted."""
    arguments = sys.argv[1:] if arguments is None else arguments
    try:
        app = build_app(arguments[0] if arguments else None)
        app(arguments)
    except ArmtwinError as error:
        _say(str(error))
        sys.exit(error.exit_code)
    except OSError as error:
        _say(f"{error.filename or 'system'}: {error.strerror or error}")
        sys.exit(1)
    except SystemExit as left:
        if left.code == _INTERRUPTED:
            _say("interrupted; the same command goes on from here")
        raise


def _nothing() -> None:
    """Stand in for what to do before every command."""


def _say(message: str) -> None:
    """Print one line on stderr."""
    Console(stderr=True, markup=False, highlight=False, soft_wrap=True).print(f"armtwin: {' '.join(message.split())}")
