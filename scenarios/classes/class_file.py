"""CLASS.toml: who is in a class, what may be wrong with their robots, and how their answers are graded.

schema = "armtwin.class/1"
title = "Robotics 3: the sealed robot"
secret = "at least sixteen characters that no student knows"
due = 2026-12-11T23:59:00+01:00

[robots]
effects = ["backlash", "gravity_sag", "servo_gain"]
none_share = 0.1

[rubric]
cause = 40

[[students]]
id = "ada"
name = "Ada Lovelace"
"""

from __future__ import annotations

from datetime import datetime, timedelta
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, field_validator, model_validator

from armtwin.models.catalogue.registry import catalogue
from armtwin.models.errors import InputError, nearest
from armtwin.models.toml_reader import read_toml
from armtwin.models.validation import FROM_LIST, NotNegative, Strict, check
from armtwin.sim.sealed import STRENGTHS, Strength

Name = Annotated[str, Field(pattern=r"^[a-z0-9][a-z0-9_-]{0,39}$")]
Share = Annotated[float, Field(ge=0, le=1)]
Tool = Literal["calibrate", "diagnose"]

# What happens at a moment would happen again when a student's bench is opened anew, and what goes wrong in detection
# has no part in a picture; what cannot be told from the geometry is no cause.
DRAWN = (
    *("backlash", "dead_band", "gravity_sag", "hysteresis", "link_bending", "marker_offset"),
    *("quantization", "servo_gain", "servo_nonlinearity"),
)


class Robots(Strict):
    """How the robots are drawn: what may be hidden, how strongly, and what share of them has nothing wrong."""

    effects: Annotated[tuple[str, ...], FROM_LIST, Field(min_length=1, max_length=30)] = DRAWN
    strength: Strength = "strong"
    none_share: Share = 0.1
    pictures: Annotated[int, Field(ge=10, le=2000)] = 100

    @field_validator("effects")
    @classmethod
    def _can_be_hidden(cls, effects: tuple[str, ...]) -> tuple[str, ...]:
        for name in effects:
            if name not in DRAWN:
                raise ValueError(f"'{name}' cannot be hidden in a served robot; {', '.join(DRAWN)} can")
        return effects

    @field_validator("strength")
    @classmethod
    def _is_a_strength(cls, strength: Strength) -> Strength:
        assert strength in STRENGTHS
        return strength


class Rubric(Strict):
    """Points for each criterion, and what earns them.

    Attributes:
        cause: the right cause; `nearly` of it for one that the effect is easily confused with.
        place: the right joint, link or marker.
        size: the parameter within `size_percent` of the truth; half within three times that.
        interval: an interval that holds the truth and is no wider than `interval_percent` of it.
        line: by how much the corrected line is nearer to the line than the drawing's commands.
        pictures: for a budget that was not spent: the share that is left when the answer is handed in.

    """

    cause: NotNegative = 40.0
    place: NotNegative = 15.0
    size: NotNegative = 15.0
    interval: NotNegative = 15.0
    line: NotNegative = 15.0
    pictures: NotNegative = 0.0
    nearly: Share = 0.5
    size_percent: Annotated[float, Field(gt=0, le=100)] = 15.0
    interval_percent: Annotated[float, Field(gt=0, le=1000)] = 60.0
    late_percent_per_day: Annotated[float, Field(ge=0, le=100)] = 10.0

    @property
    def points(self) -> dict[str, float]:
        """Points of each criterion, in order."""
        return {name: float(getattr(self, name)) for name in CRITERIA}


# A secret of fewer different letters is a key held down.
_FEWEST_LETTERS = 8

CRITERIA = ("cause", "place", "size", "interval", "line", "pictures")


class Student(Strict):
    """A student; those of one `team` share a robot."""

    id: Name
    name: Annotated[str, Field(min_length=1, max_length=200)]
    team: Name | None = None
    extension_days: Annotated[float, Field(ge=0, le=1000)] = 0.0
    gradebook_id: Annotated[str, Field(max_length=200)] = ""

    @property
    def robot(self) -> str:
        """Whose robot it is: the team's, or the student's own."""
        return f"team-{self.team}" if self.team else self.id


class ClassFile(Strict):
    """A class; `columns` maps the gradebook's column titles to `id`, `name`, `total`, or a criterion."""

    schema_: Literal["armtwin.class/1"] = Field(alias="schema")
    title: Annotated[str, Field(min_length=1, max_length=200)]
    secret: Annotated[str, Field(min_length=16, max_length=500)]
    due: datetime
    attempts: Annotated[int, Field(ge=1, le=10)] = 1
    tools: Annotated[tuple[Tool, ...], FROM_LIST] = ("calibrate", "diagnose")
    robots: Robots = Robots()
    rubric: Rubric = Rubric()
    gradebook: Literal["plain", "moodle", "canvas"] = "plain"
    columns: dict[str, str] = Field(default_factory=dict, max_length=50)
    students: Annotated[tuple[Student, ...], FROM_LIST, Field(min_length=1, max_length=500)]

    @field_validator("secret")
    @classmethod
    def _is_hard_to_guess(cls, secret: str) -> str:
        if len(set(secret)) < _FEWEST_LETTERS or secret.startswith("at least sixteen characters"):
            raise ValueError(
                "whoever guesses it knows every robot; make one with python -c 'import secrets; "
                "print(secrets.token_urlsafe(24))'"
            )
        return secret

    @field_validator("due")
    @classmethod
    def _says_its_zone(cls, due: datetime) -> datetime:
        if due.tzinfo is None:
            raise ValueError("says no time zone; write it as 2026-12-11T23:59:00+01:00")
        return due

    @model_validator(mode="after")
    def _names_differ_and_columns_are_known(self) -> ClassFile:
        ids = [student.id for student in self.students]
        twice = sorted({one for one in ids if ids.count(one) > 1})
        if twice:
            raise ValueError(f"students: id '{twice[0]}' stands twice")
        columns = [student.gradebook_id or student.id for student in self.students]
        shared = sorted({one for one in columns if columns.count(one) > 1})
        if shared:
            raise ValueError(f"students: '{shared[0]}' is the gradebook's id of two; their grades would be one's")
        taken = set(ids) & {student.robot for student in self.students if student.team}
        if taken:
            raise ValueError(f"students: '{sorted(taken)[0]}' is both an id and a team's robot")
        for title, source in self.columns.items():
            known = ("id", "name", "gradebook_id", "total", "late_days", *CRITERIA)
            if source not in known:
                raise ValueError(f"columns: '{title}': no value '{source}'; one of {', '.join(known)} is wanted")
        return self

    def student(self, name: str) -> Student:
        """Return a student by id; raises `InputError`."""
        for student in self.students:
            if student.id == name:
                return student
        raise InputError(f"no student '{name[:60]}'{nearest(name, [student.id for student in self.students])}")

    def due_of(self, student: Student, more_days: float = 0.0) -> datetime:
        """When a student's answer is due, extensions included."""
        return self.due + timedelta(days=student.extension_days + more_days)


def read_class(path: Path) -> ClassFile:
    """Read a class file; raises `InputError`."""
    return check(ClassFile, read_toml(path), path.name)


def confused(said: str, true: str) -> bool:
    """Whether one effect is easily taken for the other."""
    known = catalogue()
    return said in known and (said in known[true].confused_with or true in known[said].confused_with)
