"""What an answer is worth against the truth, by the rubric of CLASS.toml: the same inputs give the same points."""

from __future__ import annotations

import math
from dataclasses import dataclass
from datetime import datetime
from typing import Any

import numpy as np
from numpy.typing import NDArray

from armtwin.models.inverse_kinematics import inverse
from armtwin.models.trajectories import LINE_END_MM, LINE_START_MM, line
from armtwin.models.world import World
from armtwin.scenarios.classes.answer import NOTHING
from armtwin.scenarios.classes.class_file import CRITERIA, ClassFile, Rubric, Student, confused
from armtwin.scenarios.classes.course import Course
from armtwin.scenarios.classes.draw import draw_robot, hidden_in
from armtwin.sim.physics.simulation import ArmSimulation

Array = NDArray[np.float64]

_DAY_S = 86400.0
# A corrected line that takes away so much of the drawing's error has all its points: noise is left in any fit.
_FULL_GAIN = 0.8
# Where an effect vanishes, for parameters that vanish elsewhere than at zero: sizes are counted from there.
_NOTHING_AT = {"gain": 1.0}


@dataclass(frozen=True, eq=False)
class Grade:
    """What a student's attempt is worth.

    Attributes:
        student, attempt: whose, and which one it is.
        answer: what was handed in last; None: nothing.
        truth: what is hidden, as plain data; None: nothing.
        shares: of each criterion's points, 0 to 1.
        points: of each criterion.
        pictures: how many were taken when the answer was handed in.
        late_days: days begun after the due date.
        total: points, less what lateness costs.
        line_mm: mean error of the line by the drawing's commands and by the student's, mm; None: no line.
        interval_honest: whether the interval holds the truth; None: there is none to judge.

    """

    student: Student
    attempt: int
    answer: dict[str, Any] | None
    truth: dict[str, Any] | None
    shares: dict[str, float]
    points: dict[str, float]
    pictures: int
    late_days: int
    total: float
    line_mm: tuple[float, float] | None
    interval_honest: bool | None


def grade_course(course: Course) -> list[Grade]:
    """Grade every student of a course, each by his best attempt."""
    robots: dict[tuple[str, int], tuple[dict[str, Any] | None, World]] = {}
    grades = []
    for student in course.group.students:
        attempts = []
        for attempt in range(1, course.attempt(student.robot) + 1):
            key = (student.robot, attempt)
            if key not in robots:
                sealed = draw_robot(course.group, *key)
                robots[key] = (hidden_in(sealed), sealed.world)
            attempts.append(_grade(course, student, attempt, *robots[key]))
        grades.append(max(attempts, key=lambda grade: (grade.total, grade.attempt)))
    return grades


def shares_of(
    rubric: Rubric, truth: dict[str, Any] | None, answer: dict[str, Any], line_mm: tuple[float, float] | None
) -> dict[str, float]:
    """Return the share of each criterion's points, 0 to 1, but for the pictures."""
    shares = dict.fromkeys(CRITERIA, 0.0)
    shares["line"] = 0.0 if line_mm is None else _clip((1.0 - line_mm[1] / line_mm[0]) / _FULL_GAIN)
    if truth is None:  # to say so, and nothing else, is all of the answer
        right = float(answer["cause"] == NOTHING)
        return {**shares, **dict.fromkeys(("cause", "place", "size", "interval"), right)}
    if answer["cause"] != truth["effect"]:
        nearly = answer["cause"] != NOTHING and confused(answer["cause"], truth["effect"])
        shares["cause"] = rubric.nearly if nearly else 0.0
        shares["place"] = shares["cause"] * float(_same_place(truth, answer))
        return shares
    shares["cause"] = 1.0
    shares["place"] = float(_same_place(truth, answer))
    true = _true_size(truth, answer)
    if true is None or answer["value"] is None:
        return shares
    size = abs(true - _NOTHING_AT.get(answer["parameter"], 0.0))
    off = abs(answer["value"] - true) / size
    near = rubric.size_percent / 100.0
    shares["size"] = 1.0 if off <= near else 0.5 if off <= 3 * near else 0.0
    if answer["low"] is not None:
        narrow = answer["high"] - answer["low"] <= rubric.interval_percent / 100.0 * size
        shares["interval"] = float(narrow and answer["low"] <= true <= answer["high"])
    return shares


def line_errors_mm(world: World, commands: Array) -> tuple[float, float]:
    """Return the mean error of the tip along the paper's line, mm: by the drawing's commands, and by those given."""
    wanted = line(LINE_START_MM, LINE_END_MM, len(commands))
    drawn = inverse(world.arm, wanted)
    return _error_mm(world, drawn, wanted), _error_mm(world, commands, wanted)


def _grade(course: Course, student: Student, attempt: int, truth: dict[str, Any] | None, world: World) -> Grade:
    group = course.group
    answers = course.answers(student.robot, attempt)
    answer = answers[-1] if answers else None
    if answer is None:
        none = dict.fromkeys(CRITERIA, 0.0)
        return Grade(student, attempt, None, truth, none, none, 0, 0, 0.0, None, None)
    line_mm = _line_mm(world, answer)
    shares = shares_of(group.rubric, truth, answer, line_mm)
    budget = max(group.robots.pictures, 1)
    shares["pictures"] = shares["cause"] * _clip(1.0 - answer["pictures_taken"] / budget)
    points = {name: round(share * group.rubric.points[name], 2) for name, share in shares.items()}
    late = _late_days(group, course, student, answer)
    keeps = _clip(1.0 - late * group.rubric.late_percent_per_day / 100.0)
    true = None if truth is None else _true_size(truth, answer)
    honest = None if true is None or answer["low"] is None else bool(answer["low"] <= true <= answer["high"])
    total = round(sum(points.values()) * keeps, 2)
    return Grade(
        student, attempt, answer, truth, shares, points, answer["pictures_taken"], late, total, line_mm, honest
    )


def _late_days(group: ClassFile, course: Course, student: Student, answer: dict[str, Any]) -> int:
    due = group.due_of(student, course.granted(student.robot, "days"))
    late_s = (datetime.fromisoformat(answer["time"]) - due).total_seconds()
    return max(0, math.ceil(late_s / _DAY_S))


def _line_mm(world: World, answer: dict[str, Any]) -> tuple[float, float] | None:
    commands = answer["line_q_cmd_rad"]
    if commands is None or any(len(q) != world.arm.n_joints for q in commands):
        return None
    return line_errors_mm(world, np.array(commands, dtype=float))


def _error_mm(world: World, commands: Array, wanted: Array) -> float:
    arm = ArmSimulation(world)
    off = []
    for sample, (q, place) in enumerate(zip(commands, wanted, strict=True)):
        arm.move(q, sample)
        markers = arm.markers_mm()
        off.append(float(np.linalg.norm((markers[-1] - markers[0])[:2] - place[:2])))
    return float(np.mean(off))


def _same_place(truth: dict[str, Any], answer: dict[str, Any]) -> bool:
    """Whether the place is right; what has none, sitting at the whole arm, is found with its cause."""
    if truth["joint"] is None and truth["marker"] is None:
        return answer["cause"] == truth["effect"]
    return bool(answer["joint"] == truth["joint"] and (answer["marker"] or None) == truth["marker"])


def _true_size(truth: dict[str, Any], answer: dict[str, Any]) -> float | None:
    """The true value of the parameter that is named; None where it is none of the effect's, or has no size."""
    if answer["cause"] != truth["effect"] or answer["parameter"] is None:
        return None
    value = truth["parameters"].get(answer["parameter"])
    sized = isinstance(value, (int, float)) and value != _NOTHING_AT.get(answer["parameter"], 0.0)
    return float(value) if sized else None


def _clip(share: float) -> float:
    return min(1.0, max(0.0, share))
