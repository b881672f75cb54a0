"""COURSE: the folder of a class on the instructor's machine. It holds no truth, only the secret that it follows from.

class.toml             what the instructor wrote
links.csv              id, name and link's end of each student
handouts/ID.html       a page for each student
robots/ROBOT/attempt-1/recordings/recording-001/…, commands.jsonl, answers.jsonl
changes.jsonl          what the instructor granted: more time, more pictures, a fresh robot
feedback/ID.json       what a student may read of his grade, once it is released
"""

from __future__ import annotations

import html
import json
import os
import threading
from collections.abc import Iterator
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from armtwin.models import atomic
from armtwin.models.errors import InputError, JobError
from armtwin.scenarios.classes.answer import Answer
from armtwin.scenarios.classes.class_file import ClassFile, Student, read_class
from armtwin.scenarios.classes.draw import token
from armtwin.scenarios.classes.spreadsheet import spreadsheet

_MOST_LINE_BYTES = 1 << 20


@dataclass(eq=False)
class Course:
    """A class's folder; its methods may be called from any thread."""

    folder: Path
    group: ClassFile
    _lock: threading.Lock = field(default_factory=threading.Lock)

    def student_path(self, student: Student) -> str:
        """Return the end of a student's link, token included."""
        return f"s/{student.id}/?token={token(self.group, student.id)}"

    def attempt(self, robot: str) -> int:
        """Return the number of a robot's present attempt, from 1."""
        return 1 + sum(1 for change in self.changes() if change["what"] == "fresh" and change["robot"] == robot)

    def granted(self, robot: str, what: str) -> float:
        """Return the sum of what was granted to a robot: `days`, or `pictures` of its present attempt."""
        total = 0.0
        for change in self.changes():
            if change["robot"] == robot:
                total = 0.0 if change["what"] == "fresh" and what == "pictures" else total
                total += change["amount"] if change["what"] == what else 0.0
        return total

    def attempt_folder(self, robot: str, attempt: int) -> Path:
        """Return where an attempt is kept."""
        return self.folder / "robots" / robot / f"attempt-{attempt}"

    def answers(self, robot: str, attempt: int) -> list[dict[str, Any]]:
        """Return the answers handed in, oldest first."""
        lines = _lines(self.attempt_folder(robot, attempt) / "answers.jsonl")
        return [line for line in lines if line.keys() >= {"time", "pictures_taken", *Answer.model_fields}]

    def commands(self, robot: str, attempt: int) -> list[dict[str, Any]]:
        """Return what was commanded, oldest first."""
        return list(_lines(self.attempt_folder(robot, attempt) / "commands.jsonl"))

    def changes(self) -> list[dict[str, Any]]:
        """Return what was granted, oldest first."""
        return list(_lines(self.folder / "changes.jsonl"))

    def add_answer(self, robot: str, attempt: int, answer: dict[str, Any]) -> None:
        """Put an answer on disk."""
        self._append(self.attempt_folder(robot, attempt) / "answers.jsonl", answer)

    def add_command(self, robot: str, attempt: int, command: dict[str, Any]) -> None:
        """Put a command on disk."""
        self._append(self.attempt_folder(robot, attempt) / "commands.jsonl", command)

    def change(self, robot: str, what: str, amount: float = 1.0) -> None:
        """Grant `days`, `pictures` or a `fresh` robot."""
        self._append(self.folder / "changes.jsonl", {"robot": robot, "what": what, "amount": amount})

    def feedback(self, student: Student) -> dict[str, Any] | None:
        """Return the feedback that was released to a student."""
        path = self.folder / "feedback" / f"{student.id}.json"
        return json.loads(path.read_text("utf-8")) if path.is_file() else None

    def _append(self, path: Path, line: dict[str, Any]) -> None:
        """Append one line with its time, flushed to the disk before this returns."""
        text = json.dumps({"time": datetime.now(UTC).isoformat(timespec="milliseconds"), **line}, ensure_ascii=False)
        try:
            with self._lock:
                path.parent.mkdir(parents=True, exist_ok=True)
                with path.open("ab") as stream:
                    if stream.tell() and not _ends_whole(path):  # a line that a killed server left half written
                        stream.write(b"\n")
                    stream.write(text.encode() + b"\n")
                    stream.flush()
                    os.fsync(stream.fileno())
        except OSError as error:
            raise JobError(f"the server cannot write it down ({error.strerror}); tell your instructor") from None


def make_course(class_file: Path, out: Path, address: str) -> Course:
    """Make a class's folder; made again, it takes a changed class file and leaves what was measured where it is.

    `address` is where it will be served, for the hand-outs. Raises `InputError` for a class file that is wrong, and for
    a folder that holds something else or the class of another secret.
    """
    group = read_class(class_file)
    if not address.startswith(("http://", "https://")):
        raise InputError(f"--address: '{address[:80]}' is no address; https://HOST/PATH/ is wanted")
    kept = out / "class.toml"
    if out.exists() and any(out.iterdir()) and not kept.is_file():
        raise InputError(f"{out}: is not empty and holds no class; choose another --out")
    if kept.is_file() and (read_class(kept).secret, read_class(kept).robots) != (group.secret, group.robots):
        raise InputError(
            f"{out}: holds a class of another secret or other [robots], whose robots are others; choose another --out"
        )
    out.mkdir(parents=True, exist_ok=True)
    out.chmod(0o700)  # hand-outs hold tokens, and students may have accounts on this machine
    if kept.absolute() != class_file.absolute():
        atomic.write_text(kept, class_file.read_text("utf-8-sig"))
    kept.chmod(0o600)
    course = Course(out, group)
    table = [["id", "name", "robot", "link"]]
    for student in group.students:
        link = f"{address.rstrip('/')}/{course.student_path(student)}"
        table.append([student.id, student.name, student.robot, link])
        atomic.write_text(out / "handouts" / f"{student.id}.html", _handout(group, student, link))
    atomic.write_text(out / "links.csv", spreadsheet(table))
    (out / "links.csv").chmod(0o600)
    return course


def open_course(folder: Path) -> Course:
    """Open a class's folder; raises `InputError` where there is none."""
    if not (folder / "class.toml").is_file():
        raise InputError(f"{folder}: holds no class.toml; make it with armtwin lab make CLASS.toml --out {folder}")
    return Course(folder, read_class(folder / "class.toml"))


def _handout(group: ClassFile, student: Student, link: str) -> str:
    tools = ", ".join(group.tools) or "none: your own residuals and tests"
    shown = group.due.isoformat(sep=" ", timespec="minutes")
    cells = {
        "Your robot": f'<a href="{html.escape(link)}">{html.escape(link)}</a>',
        "Due": html.escape(shown),
        "Pictures": f"{group.robots.pictures} in all; each is kept",
        "Tools of the page": html.escape(tools),
        "From Python": f"<code>armtwin.open_bench({html.escape(repr(link.split('?')[0]))}, token=…)</code>",
    }
    rows = "".join(f"<tr><th>{name}</th><td>{value}</td></tr>" for name, value in cells.items())
    return (
        '<!doctype html><html lang="en"><meta charset="utf-8"><meta name="viewport" content="width=device-width">'
        f"<title>{html.escape(group.title)}</title><style>body{{font:1rem/1.5 system-ui;max-width:46rem;"
        "margin:2rem auto;padding:0 1rem}th{text-align:left;vertical-align:top;padding-right:1rem;white-space:nowrap}"
        "td{overflow-wrap:anywhere}</style>"
        f"<h1>{html.escape(group.title)}</h1><p>{html.escape(student.name)}: a robot stands ready for you. It may have "
        "one thing wrong with it, or nothing. Find out what, where and how much, with an interval, and hand it in on "
        f"the same page. The link is yours alone.</p><table>{rows}</table></html>\n"
    )


def _lines(path: Path) -> Iterator[dict[str, Any]]:
    """Yield the lines that are whole: of the last one a killed server may have left a part."""
    if not path.is_file():
        return
    with path.open("rb") as stream:
        while line := stream.readline(_MOST_LINE_BYTES):
            try:
                read = json.loads(line)
            except ValueError:
                continue
            if isinstance(read, dict):
                yield read


def _ends_whole(path: Path) -> bool:
    with path.open("rb") as stream:
        stream.seek(-1, os.SEEK_END)
        return stream.read(1) == b"\n"
