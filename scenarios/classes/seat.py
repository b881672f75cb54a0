"""A robot's seat: its bench while it is open, on the terms of its class."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np

from armtwin.models.arm import Arm
from armtwin.models.bench import Bench
from armtwin.models.errors import InputError
from armtwin.models.inverse_kinematics import inverse
from armtwin.models.plan import Plan, plan_of
from armtwin.models.trajectories import CIRCLE_CENTRE_MM, LINE_END_MM, LINE_START_MM, circle, line
from armtwin.scenarios.classes.course import Course
from armtwin.scenarios.classes.draw import draw_robot, generator
from armtwin.scenarios.classes.sealed_bench import SealedBench
from armtwin.scenarios.scenario import EffectTable
from armtwin.scenarios.serving.pace import Pace
from armtwin.scenarios.serving.sources import BenchSource, Terms
from armtwin.scenarios.serving.visit import Visit

_CIRCLE_POSES, _LINE_POSES = 16, 8


class Seat:
    """A robot of a course; its bench is drawn when somebody first sits down. `thread` and `slots` are everybody's."""

    def __init__(
        self, course: Course, robot: str, thread: ThreadPoolExecutor, slots: threading.BoundedSemaphore
    ) -> None:
        self.course, self.robot = course, robot
        self._thread, self._slots = thread, slots
        self._visit: Visit | None = None
        self._attempt = 0
        self._lock = threading.Lock()

    @property
    def attempt(self) -> int:
        """The number of the present attempt."""
        return self.course.attempt(self.robot)

    @property
    def pictures(self) -> int:
        """How many pictures the present attempt has in all."""
        return self.course.group.robots.pictures + int(self.course.granted(self.robot, "pictures"))

    def visit(self) -> Visit:
        """Return the visit of the present attempt, opened if it is not yet."""
        with self._lock:
            attempt = self.attempt
            if self._visit is None or self._attempt != attempt:
                self._close()
                folder = self.course.attempt_folder(self.robot, attempt)
                self._visit = Visit(self._source(attempt), folder, self._thread, self._slots)
                self._attempt = attempt
            return self._visit

    def begin_another(self) -> int:
        """Begin another attempt, whose number is returned; raises `InputError` where none is allowed (yet)."""
        allowed = self.course.group.attempts
        with self._lock:  # of two tabs that ask at a time one is too late
            if self.attempt >= allowed:
                raise InputError(f"attempt: {allowed} are allowed, and this is number {self.attempt}")
            if not self.course.answers(self.robot, self.attempt):
                raise InputError("attempt: hand in an answer to this robot first")
            self.course.change(self.robot, "fresh")
            return self.attempt

    def close(self) -> None:
        """Close the bench, if it is open."""
        with self._lock:
            self._close()

    def _close(self) -> None:
        if self._visit is not None:
            self._visit.close()
        self._visit = None

    def _source(self, attempt: int) -> BenchSource:
        course, robot, pace = self.course, self.robot, Pace()
        world = draw_robot(course.group, robot, attempt).world

        def make(_: Sequence[EffectTable], pictures_before: int) -> Bench:
            # The noise of a picture follows from its number: opening the bench anew buys no second look.
            return SealedBench(world, generator(course.group, "noise", robot, str(attempt), str(pictures_before)), pace)

        return BenchSource(
            title=course.group.title,
            description=SealedBench(world, np.random.default_rng(0)).description,
            plans=plans_of(world.arm),
            make=make,
            takes_faults=False,
            release=lambda: None,
            terms=Terms(
                pictures=lambda: self.pictures,
                tools=tuple(course.group.tools),
                told=lambda command: course.add_command(robot, attempt, command),
                pace=pace,
            ),
        )

    def standing(self) -> dict[str, Any]:
        """Say how things stand, without opening anything."""
        attempt = self.attempt
        commands = self.course.commands(self.robot, attempt)
        answers = self.course.answers(self.robot, attempt)
        return {
            "attempt": attempt,
            "pictures_taken": sum(1 for command in commands if command["what"] == "picture"),
            "pictures": self.pictures,
            "last_command": commands[-1]["time"] if commands else None,
            "answers": len(answers),
            "last_answer": answers[-1]["time"] if answers else None,
        }


def plans_of(arm: Arm) -> dict[str, Plan]:
    """Return the plans that every student's page offers."""
    paths = {
        "circle": circle(CIRCLE_CENTRE_MM, 25.0, _CIRCLE_POSES),
        "line": line(LINE_START_MM, LINE_END_MM, _LINE_POSES),
    }
    return {name: plan_of({name: inverse(arm, poses)}) for name, poses in paths.items()}
