"""`armtwin lab`: notebooks for students, robots for a class."""

from __future__ import annotations

import importlib.util
import os
import sys
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table

from armtwin.models.errors import InputError
from armtwin.scenarios.commands.outputs import only_results
from armtwin.scenarios.labs.shelf import LABS, lab_numbered, students_copy

# marimo shows a notebook's cells unrun unless its own settings say otherwise; a lab opens as a page that works. What
# would send a student's notebook to somebody else's server is left out of its menus.
_SETTINGS = {"_MARIMO_CONFIG_OVERLOAD_RUNTIME_AUTO_INSTANTIATE": "true", "MARIMO_RESTRICT_SHARING": "true"}

_HELP = """Labs without a robot: notebooks for a student, robots for a class.

Example: armtwin lab open 4
"""

lab_command = typer.Typer(no_args_is_help=True, help=_HELP)


@lab_command.command("list")
def list_command() -> None:
    """List the labs.

    Example: armtwin lab list
    """
    table = Table("lab", "what it is about", "minutes", box=None)
    for lab in LABS:
        table.add_row(str(lab.number), lab.title, str(lab.minutes))
    Console(soft_wrap=True).print(table)
    Console(soft_wrap=True).print("armtwin lab open N opens one in the browser", highlight=False)


@lab_command.command("open")
def open_command(
    number: Annotated[int, typer.Argument(metavar="N", help="The lab's number.")],
    folder: Annotated[Path, typer.Option("--folder", help="Where your copies of the notebooks are.")] = Path("labs"),
    port: Annotated[int, typer.Option("--port", min=0, max=65535, help="0 takes a free one.")] = 0,
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="Whether to open the browser.")] = True,
) -> None:
    """Open a lab in the browser: your own copy of its notebook, made the first time and never overwritten.

    The notebook runs on this machine and asks the network for nothing. Its address holds a token; Ctrl-C ends it, and
    what you wrote stays in --folder.

    Example: armtwin lab open 4
    """
    lab = lab_numbered(number)
    if importlib.util.find_spec("marimo") is None:
        raise InputError("lab open: marimo is not installed; install armtwin[labs]")
    path = students_copy(lab, folder)
    options = ["--skip-update-check", "--no-sandbox", *(["--port", str(port)] if port else [])]
    options += [] if browser else ["--headless"]
    Console(stderr=True, highlight=False, soft_wrap=True).print(f"armtwin: your notebook is {path}", markup=False)
    words = [sys.executable, "-m", "marimo", "edit", str(path), *options]
    os.execve(sys.executable, words, {**os.environ, **_SETTINGS})  # noqa: S606  # it ends as this command would


@lab_command.command("make")
def make_command(
    class_file: Annotated[Path, typer.Argument(metavar="CLASS.toml", help="Roster, secret, due date, rubric.")],
    out: Annotated[Path, typer.Option("--out", help="Folder of the class, for your machine alone.")],
    address: Annotated[
        str, typer.Option("--address", help="Where you will serve it: it stands in the links.")
    ] = "http://127.0.0.1:8000/",
) -> None:
    """Make a class: a sealed robot and a link for each student, a hand-out page each.

    Robots follow from the secret and each student's id; no file holds what is wrong with them. Made again with a
    changed CLASS.toml (a new student, another rubric, an extension) it leaves what was measured and handed in as it is.

    Example: armtwin lab make CLASS.toml --out course --address https://lab.example.org/robots/
    """
    from armtwin.scenarios.classes.course import make_course

    with only_results(out):
        course = make_course(class_file, out, address)
    screen = Console(stderr=True, highlight=False, soft_wrap=True)
    screen.print(f"armtwin: {len(course.group.students)} students; links in {out / 'links.csv'}", markup=False)
    screen.print(f"armtwin: serve it with: armtwin serve --class {out}", markup=False)


@lab_command.command("grade")
def grade_command(
    course: Annotated[Path, typer.Argument(metavar="COURSE", help="Folder of the class.")],
    out: Annotated[Path, typer.Option("--out", help="Folder for grades.csv, gradebook.csv and report.html.")],
    release: Annotated[
        bool, typer.Option("--release", help="Let the students read which criteria they met; never the truth.")
    ] = False,
) -> None:
    """Grade what was handed in against the truth, by the rubric in the class's file.

    Example: armtwin lab grade course --out grades
    """
    from armtwin.scenarios.classes.course import open_course
    from armtwin.scenarios.classes.gradebook import release as let_read
    from armtwin.scenarios.classes.gradebook import write_grades
    from armtwin.scenarios.classes.grading import grade_course

    opened = open_course(course)
    with only_results(out):
        grades = grade_course(opened)
        write_grades(out, opened, grades)
    if release:
        let_read(opened, grades)
    found = sum(grade.shares["cause"] == 1.0 for grade in grades)
    screen = Console(stderr=True, highlight=False, soft_wrap=True)
    screen.print(f"armtwin: {found} of {len(grades)} found the cause; see {out / 'report.html'}", markup=False)
