"""A class of three robots: one for a student who finds out, one for a guesser, one that a pair shares."""

from __future__ import annotations

import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from armtwin.scenarios.classes.course import Course, make_course
from armtwin.scenarios.classes.draw import token

CLASS = """
schema = "armtwin.class/1"
title = "The sealed robot"
secret = "correct horse battery staple 3"
due = 2099-12-11T23:59:00+01:00
attempts = 2
gradebook = "moodle"

[robots]
effects = ["backlash", "servo_gain", "gravity_sag"]
none_share = 0.0
pictures = 40

[[students]]
id = "ada"
name = "Ada Lovelace"

[[students]]
id = "alan"
name = "=Alan Turing"

[[students]]
id = "grace"
name = "Grace Hopper"
team = "navy"

[[students]]
id = "jean"
name = "Jean Bartik"
team = "navy"
"""


@pytest.fixture
def course(tmp_path: Path) -> Course:
    return new_course(tmp_path)


def new_course(folder: Path, text: str = CLASS) -> Course:
    file = folder / "CLASS.toml"
    file.write_text(text, "utf-8")
    return make_course(file, folder / "course", "http://127.0.0.1:8000/")


@dataclass(frozen=True)
class ServedClass:
    """The process, its address without a slash at the end, and its course."""

    process: subprocess.Popen[str]
    url: str
    course: Course

    def bench(self, student: str) -> str:
        return f"{self.url}/s/{student}/"

    def token(self, student: str) -> str:
        return token(self.course.group, student)

    def headers(self, student: str) -> dict[str, str]:
        return {"Authorization": f"Bearer {self.token(student)}"}


def serve(course: Course, *options: str) -> ServedClass:
    """Start `armtwin serve --class` and wait until it says where."""
    words = [sys.executable, "-m", "armtwin", "serve", "--class", str(course.folder), "--port", "0", *options]
    process = subprocess.Popen(words, stderr=subprocess.PIPE, text=True)
    assert process.stderr is not None
    for line in process.stderr:
        found = re.search(r"(http://127\.0\.0\.1:\d+\S*)/instructor/", line)
        if found:
            return ServedClass(process, found[1], course)
    raise AssertionError(f"the server ended with {process.wait()} and said nothing of its address")


def answered(**said: Any) -> dict[str, Any]:
    """An answer as it is handed in, what is not said left out."""
    return {"cause": "none", **said}
