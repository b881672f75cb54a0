"""Grades follow from truth, answer and rubric, are the same each time, and feedback keeps the truth."""

from __future__ import annotations

import csv
import io
import threading
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import pytest

from armtwin.models.errors import InputError, JobError
from armtwin.scenarios.classes.class_file import Rubric, read_class
from armtwin.scenarios.classes.course import Course, make_course, open_course
from armtwin.scenarios.classes.draw import draw_robot, hidden_in, token
from armtwin.scenarios.classes.gradebook import alike, release, write_grades
from armtwin.scenarios.classes.grading import grade_course, shares_of
from armtwin.scenarios.classes.seat import Seat
from tests.scenarios.classes.conftest import CLASS, new_course
from tests.support.disks import grow, mounted

PLAY = {"effect": "backlash", "joint": 2, "marker": None, "parameters": {"width_rad": 0.02}}
GAIN = {"effect": "servo_gain", "joint": 1, "marker": None, "parameters": {"gain": 1.04}}
SAG = {"effect": "gravity_sag", "joint": None, "marker": None, "parameters": {"compliance1_rad_per_nm": 0.1}}


def said(**parts: Any) -> dict[str, Any]:
    none = dict.fromkeys(("joint", "marker", "parameter", "value", "low", "high", "line_q_cmd_rad"))
    return {**none, "argument": "", "pictures_taken": 10, **parts}


def test_an_answer_that_is_right_in_all_has_all_points() -> None:
    answer = said(cause="backlash", joint=2, parameter="width_rad", value=0.0195, low=0.017, high=0.022)
    shares = shares_of(Rubric(), PLAY, answer, (4.0, 0.2))
    assert shares == {"cause": 1, "place": 1, "size": 1, "interval": 1, "line": 1, "pictures": 0}


@pytest.mark.parametrize(
    ("truth", "parts", "expected"),
    [
        (PLAY, {"cause": "backlash", "joint": 1}, {"cause": 1, "place": 0, "size": 0}),
        (PLAY, {"cause": "hysteresis", "joint": 2}, {"cause": 0.5, "place": 0.5, "size": 0}),
        (PLAY, {"cause": "gravity_sag"}, {"cause": 0, "place": 0}),
        (PLAY, {"cause": "none"}, {"cause": 0, "interval": 0}),
        (PLAY, {"cause": "backlash", "joint": 2, "parameter": "width_rad", "value": 0.026}, {"size": 0.5}),
        (PLAY, {"cause": "backlash", "joint": 2, "parameter": "friction_nm", "value": 0.02}, {"size": 0}),
        (SAG, {"cause": "gravity_sag"}, {"cause": 1, "place": 1}),
        (GAIN, {"cause": "servo_gain", "joint": 1, "parameter": "gain", "value": 1.0}, {"cause": 1, "size": 0}),
        (GAIN, {"cause": "servo_gain", "joint": 1, "parameter": "gain", "value": 1.039}, {"size": 1}),
        (None, {"cause": "none"}, {"cause": 1, "place": 1, "size": 1, "interval": 1}),
        (None, {"cause": "backlash"}, {"cause": 0, "place": 0}),
    ],
)
def test_partial_credit(truth: dict[str, Any] | None, parts: dict[str, Any], expected: dict[str, float]) -> None:
    shares = shares_of(Rubric(), truth, said(**parts), None)
    assert {name: shares[name] for name in expected} == expected


def test_an_interval_earns_nothing_where_it_misses_the_truth_or_says_nothing() -> None:
    whole = {"cause": "backlash", "joint": 2, "parameter": "width_rad", "value": 0.02}
    assert shares_of(Rubric(), PLAY, said(**whole, low=0.0205, high=0.022), None)["interval"] == 0
    assert shares_of(Rubric(), PLAY, said(**whole, low=0.0, high=1.0), None)["interval"] == 0
    assert shares_of(Rubric(), PLAY, said(**whole, low=0.018, high=0.022), None)["interval"] == 1


def test_the_same_inputs_give_the_same_grades_and_feedback_names_no_truth(course: Course, tmp_path: Path) -> None:
    truth = _hand_in_what_is_true(course, "ada")
    course.add_answer("team-navy", 1, {"by": "jean", **said(cause="none")})
    for out in ("one", "two"):
        write_grades(tmp_path / out, course, grade_course(course))
    for name in ("grades.csv", "gradebook.csv", "report.html"):
        assert (tmp_path / "one" / name).read_bytes() == (tmp_path / "two" / name).read_bytes()
    table = list(csv.DictReader(io.StringIO((tmp_path / "one" / "gradebook.csv").read_text())))
    assert table[1]["Full name"] == "'=Alan Turing"  # no spreadsheet takes it for a formula
    assert float(table[0]["The sealed robot"]) >= 70
    whole = list(csv.DictReader(io.StringIO((tmp_path / "one" / "grades.csv").read_text())))
    assert [row["cause_said"] for row in whole] == [truth["effect"], "", "none", "none"]
    assert table[2]["The sealed robot"] == table[3]["The sealed robot"]
    assert truth["effect"] in (tmp_path / "one" / "report.html").read_text()

    student = course.group.student("alan")
    assert course.feedback(student) is None
    release(course, grade_course(course))
    feedback = (course.folder / "feedback" / "alan.json").read_text()
    assert not any(name in feedback for name in course.group.robots.effects)
    assert set(course.feedback(student) or {}) == {"attempt", "total", "late_days", "criteria"}


def test_a_changed_rubric_grades_anew_and_lateness_costs_until_an_extension(course: Course) -> None:
    _hand_in_what_is_true(course, "ada")
    full = grade_course(course)[0].total
    due = datetime.now(UTC) - timedelta(hours=30)
    late = Course(course.folder, course.group.model_copy(update={"due": due}))
    grade = grade_course(late)[0]
    assert (grade.late_days, grade.total) == (2, round(full * 0.8, 2))
    late.change("ada", "days", 2)
    assert grade_course(late)[0].total == full
    rubric = replace_points(late, cause=10.0)
    assert grade_course(rubric)[0].total == full - 30


def test_the_better_attempt_counts(course: Course) -> None:
    _hand_in_what_is_true(course, "ada")
    course.change("ada", "fresh")
    course.add_answer("ada", 2, {"by": "ada", **said(cause="none")})
    grade = grade_course(course)[0]
    assert grade.attempt == 1


def test_answers_and_commands_that_look_copied_are_shown(course: Course) -> None:
    for robot in ("ada", "alan", "team-navy"):
        for step in range(8):
            shift = 0.5 if robot == "team-navy" else 0.0
            course.add_command(robot, 1, {"what": "move", "q_cmd_rad": [0.01 * step, 0.0, 0.1]})  # on the way
            course.add_command(robot, 1, {"what": "move", "q_cmd_rad": [0.1 * step + shift, 0.2, 0.1]})
            course.add_command(robot, 1, {"what": "picture", "number": step + 1})
    course.add_command("ada", 1, {"what": "picture", "number": 9})  # one more hides nothing
    answer = said(cause="backlash", joint=1, parameter="width_rad", value=0.0123456)
    for robot in ("alan", "team-navy"):
        course.add_answer(robot, 1, answer)
    assert alike(course) == [("ada", "alan", "poses"), ("alan", "team-navy", "answer")]


def test_links_hold_other_tokens_for_everyone_and_another_secret_makes_other_robots(course: Course) -> None:
    tokens = {token(course.group, who) for who in ("", "ada", "alan", "grace", "jean")}
    assert len(tokens) == 5
    other = course.group.model_copy(update={"secret": "another secret of this length"})
    assert draw_robot(other, "ada", 1).truth != draw_robot(course.group, "ada", 1).truth


def test_a_class_made_again_keeps_what_was_handed_in_and_refuses_another_secret(tmp_path: Path) -> None:
    course = new_course(tmp_path)
    course.add_answer("ada", 1, said(cause="none"))
    again = new_course(tmp_path, CLASS.replace("Ada Lovelace", "Ada King"))
    assert again.group.student("ada").name == "Ada King"
    assert len(open_course(again.folder).answers("ada", 1)) == 1
    for other in (CLASS.replace("staple 3", "staple 4"), CLASS.replace('"servo_gain", ', "")):
        with pytest.raises(InputError, match="robots are others"):
            new_course(tmp_path, other)


@pytest.mark.parametrize(
    ("change", "named"),
    [
        (("effects = [", 'effects = ["camera_moved", '), "camera_moved"),
        (("effects = [", 'effects = ["poltergeist", '), "poltergeist"),
        (('id = "alan"', 'id = "ada"'), "stands twice"),
        (('id = "alan"', 'id = "../alan"'), "id"),
        (("+01:00", ""), "time zone"),
        (('secret = "correct horse battery staple 3"', 'secret = "short"'), "secret"),
        (("correct horse battery staple 3", "aaaaaaaaaaaaaaaaaaaaaaaa"), "token_urlsafe"),
        (("correct horse battery staple 3", "at least sixteen characters that no student knows"), "token_urlsafe"),
        (('id = "alan"', 'id = "alan"\ngradebook_id = "ada"'), "gradebook's id of two"),
        (("attempts = 2", "atempts = 2"), "attempts"),
    ],
)
def test_a_class_file_that_is_wrong_is_one_line_that_names_it(
    tmp_path: Path, change: tuple[str, str], named: str
) -> None:
    file = tmp_path / "CLASS.toml"
    file.write_text(CLASS.replace(*change, 1), "utf-8")
    with pytest.raises(InputError, match=r"CLASS\.toml") as error:
        read_class(file)
    assert named in str(error.value)
    assert "\n" not in str(error.value)


def test_a_class_is_for_its_instructor_alone_and_names_are_no_formulas(tmp_path: Path) -> None:
    odd = """Zoë "Ω", née O'Brien"""
    course = new_course(
        tmp_path, CLASS.replace('"=Alan Turing"', "\"=cmd|' /C calc'!A0\"").replace('"Ada Lovelace"', f"'''{odd}'''")
    )
    assert course.folder.stat().st_mode & 0o077 == 0
    rows = list(csv.reader(io.StringIO((course.folder / "links.csv").read_text("utf-8"))))
    assert [row[1] for row in rows[1:3]] == [odd, "'=cmd|' /C calc'!A0"]
    assert all(not cell.startswith("=") for row in rows for cell in row)


def test_an_address_that_makes_no_link_is_refused(tmp_path: Path) -> None:
    (tmp_path / "CLASS.toml").write_text(CLASS)
    with pytest.raises(InputError, match="--address"):
        make_course(tmp_path / "CLASS.toml", tmp_path / "course", "lab.example.org")


def test_what_is_declared_of_a_robot_is_the_same_for_all(course: Course) -> None:
    declared = {
        tuple(draw_robot(course.group, robot, attempt).world.arm.gravity_m_s2)
        for robot in ("ada", "alan", "team-navy")
        for attempt in (1, 2)
    }
    assert declared == {(0.0, -9.81)}


def test_of_two_tabs_that_begin_another_attempt_at_a_time_one_does(course: Course) -> None:
    course.add_answer("ada", 1, said(cause="none"))
    seat = Seat(course, "ada", ThreadPoolExecutor(1), threading.BoundedSemaphore(1))

    def begin(_: int) -> bool:
        try:
            return seat.begin_another() == 2
        except InputError:
            return False

    with ThreadPoolExecutor(8) as tabs:
        assert sum(tabs.map(begin, range(8))) == 1
    assert course.attempt("ada") == 2


def test_an_answer_on_a_full_disk_is_told_and_the_next_one_is_whole(tmp_path: Path) -> None:
    with mounted(tmp_path, 1) as mount:
        course = new_course(mount)
        kept = 0
        try:
            for _ in range(400):
                course.add_answer("ada", 1, said(cause="none", argument="x" * 4000))
                kept += 1
        except JobError as error:
            assert "No space left" in str(error)  # noqa: PT017  # some fit, then one does not
        grow(mount, 2)
        course.add_answer("ada", 1, said(cause="backlash"))
        answers = course.answers("ada", 1)
        assert 10 < kept < 400
        assert len(answers) == kept + 1
        assert answers[-1]["cause"] == "backlash"


def test_a_folder_of_something_else_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "CLASS.toml").write_text(CLASS)
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.tex").write_text("all of it")
    with pytest.raises(InputError, match="not empty"):
        make_course(tmp_path / "CLASS.toml", tmp_path / "mine", "http://127.0.0.1/")


def _hand_in_what_is_true(course: Course, robot: str) -> dict[str, Any]:
    truth = hidden_in(draw_robot(course.group, robot, 1))
    assert truth is not None
    name, value = next((k, v) for k, v in truth["parameters"].items() if v)
    answer = said(cause=truth["effect"], joint=truth["joint"], parameter=name, value=value)
    course.add_answer(robot, 1, {"by": robot, **answer, "low": 0.95 * value, "high": 1.05 * value})
    return truth


def replace_points(course: Course, **points: float) -> Course:
    rubric = course.group.rubric.model_copy(update=points)
    return replace(course, group=course.group.model_copy(update={"rubric": rubric}))
