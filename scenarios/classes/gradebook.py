"""GRADES: the gradebook's table, a page for the instructor, and feedback that names criteria and no truth."""

from __future__ import annotations

import html
from collections import defaultdict
from collections.abc import Iterator, Sequence
from itertools import combinations
from pathlib import Path
from typing import Any

from armtwin.models import atomic
from armtwin.models.arm import nominal_arm
from armtwin.scenarios.classes.class_file import CRITERIA, ClassFile
from armtwin.scenarios.classes.course import Course
from armtwin.scenarios.classes.grading import Grade
from armtwin.scenarios.classes.seat import plans_of
from armtwin.scenarios.classes.spreadsheet import spreadsheet
from armtwin.scenarios.scoring.judge import label

# What the two gradebooks want to see at the head of a column, where CLASS.toml names no columns of its own.
_COLUMNS = {
    "moodle": {"ID number": "gradebook_id", "Full name": "name", "TITLE": "total"},
    "canvas": {"Student": "name", "ID": "gradebook_id", "SIS Login ID": "id", "Section": "", "TITLE": "total"},
}
# Who took pictures of so many of another's poses is shown to the instructor; the page's own plans aside.
_ALIKE = 6


def write_grades(out: Path, course: Course, grades: Sequence[Grade]) -> None:
    """Write grades.csv (a column a criterion), gradebook.csv (the column map) and report.html."""
    atomic.write_text(out / "grades.csv", _table(grades))
    atomic.write_text(out / "gradebook.csv", _gradebook(course.group, grades))
    atomic.write_text(out / "report.html", _page(course, grades))


def release(course: Course, grades: Sequence[Grade]) -> None:
    """Let every student read which criteria he met; of the truth nothing is said."""
    for grade in grades:
        rubric = course.group.rubric.points
        feedback = {
            "attempt": grade.attempt,
            "total": grade.total,
            "late_days": grade.late_days,
            "criteria": {name: {"points": grade.points[name], "of": rubric[name]} for name in CRITERIA if rubric[name]},
        }
        atomic.write_json(course.folder / "feedback" / f"{grade.student.id}.json", feedback)


def alike(course: Course) -> list[tuple[str, str, str]]:
    """Return pairs of students who share no robot and whose poses or answers look alike, with what is alike."""
    seen: dict[tuple[str, Any], list[str]] = defaultdict(list)
    pictured: dict[str, set[tuple[float, ...]]] = {}
    offered = {tuple(q) for plan in plans_of(nominal_arm()).values() for q in plan.q_cmd.tolist()}
    for robot in dict.fromkeys(student.robot for student in course.group.students):
        attempt = course.attempt(robot)
        pictured[robot] = set(_pictured(course.commands(robot, attempt))) - offered
        for answer in course.answers(robot, attempt)[-1:]:
            if answer["value"] is not None:
                seen[("answer", (answer["cause"], answer["parameter"], answer["value"]))].append(robot)
            if len(answer["argument"].split()) >= _ALIKE:
                seen[("argument", " ".join(answer["argument"].split()))].append(robot)
    same = [
        (*pair, "poses") for pair in combinations(pictured, 2) if len(pictured[pair[0]] & pictured[pair[1]]) >= _ALIKE
    ]
    return same + [(*pair, what) for (what, _), robots in seen.items() for pair in combinations(robots, 2)]


def _pictured(commands: Sequence[dict[str, Any]]) -> Iterator[tuple[float, ...]]:
    """Yield the poses of which pictures were taken: what somebody tried on the way is the page's steps."""
    q: tuple[float, ...] | None = None
    for command in commands:
        if command["what"] == "move":
            q = tuple(command["q_cmd_rad"])
        elif command["what"] == "picture" and q is not None:
            yield q


def _table(grades: Sequence[Grade]) -> str:
    head = ["id", "name", "robot", "attempt", "cause_said", *(f"{name}_points" for name in CRITERIA)]
    rows = [
        [
            *(grade.student.id, grade.student.name, grade.student.robot, grade.attempt),
            "" if grade.answer is None else grade.answer["cause"],
            *(grade.points[name] for name in CRITERIA),
            *(grade.pictures, grade.late_days, grade.total),
        ]
        for grade in grades
    ]
    return spreadsheet([[*head, "pictures", "late_days", "total_points"], *rows])


def _gradebook(group: ClassFile, grades: Sequence[Grade]) -> str:
    plain = {"id": "id", "name": "name", **{name: name for name in CRITERIA}, "total": "total"}
    columns = group.columns or _COLUMNS.get(group.gradebook, plain)
    rows = [[title.replace("TITLE", group.title) for title in columns]]
    for grade in grades:
        values = {
            "id": grade.student.id,
            "name": grade.student.name,
            "gradebook_id": grade.student.gradebook_id or grade.student.id,
            "total": str(grade.total),
            "late_days": str(grade.late_days),
            **{name: str(points) for name, points in grade.points.items()},
            "": "",
        }
        rows.append([values[source] for source in columns.values()])
    return spreadsheet(rows)


def _page(course: Course, grades: Sequence[Grade]) -> str:
    group = course.group
    head = ["student", "truth", "said", *CRITERIA, "pictures", "interval", "line before → after, mm", "late", "total"]
    body = []
    for grade in grades:
        honest = {None: "", True: "holds the truth", False: "misses the truth"}[grade.interval_honest]
        errors = "" if grade.line_mm is None else f"{grade.line_mm[0]:.2f} → {grade.line_mm[1]:.2f}"
        answer = grade.answer
        said = "nothing handed in" if answer is None else label({**answer, "effect": answer["cause"]})
        body.append(
            [
                grade.student.name,
                "nothing" if grade.truth is None else f"{label(grade.truth)} {_sizes(grade.truth)}",
                said if answer is None or answer["value"] is None else f"{said} {answer['value']:.4g}",
                *(f"{grade.points[name]:g}" for name in CRITERIA),
                *(str(grade.pictures), honest, errors, f"{grade.late_days} d" if grade.late_days else ""),
                f"{grade.total:g}",
            ]
        )
    of = ", ".join(f"{name} {points:g}" for name, points in group.rubric.points.items() if points)
    found = sum(grade.shares["cause"] == 1.0 for grade in grades)
    pairs = alike(course)
    look = "".join(f"<li>{_safe(a)} and {_safe(b)}: the same {_safe(what)}</li>" for a, b, what in pairs)
    return (
        '<!doctype html><html lang="en"><meta charset="utf-8"><meta name="viewport" content="width=device-width">'
        f"<title>{_safe(group.title)}: grades</title><style>body{{font:1rem/1.5 system-ui;margin:1.5rem}}"
        ".wide{overflow-x:auto}table{border-collapse:collapse}th,td{text-align:left;padding:.2rem .8rem .2rem 0;"
        "border-bottom:1px solid #ddd;white-space:nowrap}</style>"
        f"<h1>{_safe(group.title)}: grades</h1><p>{found} of {len(grades)} found the cause. Points: {_safe(of)}; "
        f"{group.rubric.late_percent_per_day:g} % off a day late.</p><div class=wide><table><tr>"
        + "".join(f"<th>{_safe(name)}</th>" for name in head)
        + "</tr>"
        + "".join("<tr>" + "".join(f"<td>{_safe(cell)}</td>" for cell in row) + "</tr>" for row in body)
        + "</table></div>"
        + (f"<h2>Look at these yourself</h2><ul>{look}</ul>" if look else "")
        + "</html>\n"
    )


def _sizes(truth: dict[str, Any]) -> str:
    numbers = {k: v for k, v in truth["parameters"].items() if isinstance(v, (int, float)) and v}
    return ", ".join(f"{name} {value:.4g}" for name, value in numbers.items())


def _safe(text: str) -> str:
    return html.escape(str(text))
