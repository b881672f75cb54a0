"""The command line: one app, its commands imported only when they are called for."""

from __future__ import annotations

import errno
import importlib
import os
import sys
import traceback
from importlib import metadata
from typing import Annotated

import typer
from rich.console import Console

from armtwin.models.errors import ArmtwinError, InputError
from armtwin.scenarios.commands.interrupts import interrupts_deferred
from armtwin.scenarios.unwaited import leave

# Command -> module and function under scenarios/commands.
COMMANDS = {
    "run": "run:run_command",
    "capture": "capture:capture_command",
    "snapshot": "snapshot:snapshot_command",
    "calibrate-camera": "calibrate_camera:calibrate_camera_command",
    "measure": "measure:measure_command",
    "calibrate": "calibrate:calibrate_command",
    "diagnose": "diagnose:diagnose_command",
    "doctor": "doctor:doctor_command",
    "targets": "targets:targets_command",
    "bench-check": "bench_check:bench_check_command",
    "serve": "serve:serve_command",
    "seal": "seal:seal_command",
    "score": "score:score_command",
    "sweep": "sweep:sweep_command",
    "power": "power:power_command",
    "effects": "effects:effects_command",
    "export": "export:export_command",
    "correct": "correct:correct_command",
    "simulate": "simulate:simulate_command",
    "import": "import_:import_command",
    "lab": "lab:lab_command",
}
# What the system says of a path that was given wrongly, rather than of a disk that is full or breaks.
_WRONG_PATH = {
    *(errno.ENOENT, errno.ENOTDIR, errno.EISDIR, errno.EEXIST, errno.ENAMETOOLONG, errno.ELOOP),
    *(errno.EACCES, errno.EPERM, errno.EROFS),
}
# What a shell reports for a program that was ended by Ctrl-C: 128 + SIGINT.
_INTERRUPTED = 130


def build_app(wanted: str | None = None) -> typer.Typer:
    """Return the app; with the name of one command only that one is imported, which keeps the start fast."""
    app = typer.Typer(name="armtwin", no_args_is_help=True, add_completion=False, pretty_exceptions_enable=False)
    app.callback(help="A simulation-first digital twin of a planar servo arm watched by one webcam.")(_before)
    for name in [wanted] if wanted in COMMANDS else list(COMMANDS):
        module, function = COMMANDS[name].split(":")
        command = getattr(importlib.import_module(f"armtwin.scenarios.commands.{module}"), function)
        if isinstance(command, typer.Typer):  # a family of commands
            app.add_typer(command, name=name)
        else:
            app.command(name, no_args_is_help=False)(command)
    return app


def main(arguments: list[str] | None = None) -> None:
    """Run the command line and leave with 0 done, 1 the job failed, 2 the input is wrong, 130 interrupted.

    A defect of armtwin's own is one line too; with ARMTWIN_TRACEBACK set its traceback follows.
    """
    arguments = sys.argv[1:] if arguments is None else arguments
    os.environ.setdefault("OPENCV_LOG_LEVEL", "ERROR")  # its warnings of a corrupt picture stand beside our own line
    try:
        with interrupts_deferred():
            app = build_app(arguments[0] if arguments else None)
        code = app(arguments, standalone_mode=False) or 0
    except KeyboardInterrupt:
        code = _INTERRUPTED
    except typer.Abort:
        _say("given up: no answer at the terminal")
        code = 1
    except typer.TyperException as error:  # a wrong option, argument or command; empty after the help was shown
        if error.format_message():
            _say(f"{error.format_message().rstrip('.')}; see armtwin {_command_of(arguments)}--help")
        code = error.exit_code
    except ArmtwinError as error:
        _say(str(error))
        code = error.exit_code
    except OSError as error:
        _say(f"{error.filename or 'system'}: {error.strerror or error}")
        code = InputError.exit_code if error.errno in _WRONG_PATH else 1
    except Exception as error:  # noqa: BLE001  # a defect of ours
        _say(f"broke down ({type(error).__name__}: {error}); set ARMTWIN_TRACEBACK=1 to see where, and report it")
        if os.environ.get("ARMTWIN_TRACEBACK"):
            traceback.print_exc()
        code = 1
    if code == _INTERRUPTED:
        _say("interrupted; the same command goes on from here")
    leave(code)


def _command_of(arguments: list[str]) -> str:
    return f"{arguments[0]} " if arguments and arguments[0] in COMMANDS else ""


def _tell_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"armtwin {metadata.version('armtwin')}")
        raise typer.Exit


def _before(
    version: Annotated[
        bool, typer.Option("--version", callback=_tell_version, is_eager=True, help="Print the version and leave.")
    ] = False,
) -> None:
    """Stand for what comes before every command."""


def _say(message: str) -> None:
    """Print one line on stderr; what a file smuggles in to control the terminal is shown as '?'."""
    line = "".join(c if c.isprintable() else "?" for c in " ".join(message.split()))
    Console(stderr=True, markup=False, highlight=False, soft_wrap=True).print(f"armtwin: {line}")
