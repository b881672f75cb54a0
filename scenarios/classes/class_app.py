"""A class over HTTP: each student's bench under s/ID/, the instructor's page under instructor/, over one port."""

from __future__ import annotations

import asyncio
import sys
import threading
from collections.abc import AsyncIterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import asynccontextmanager
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Annotated, Any, Literal

from fastapi import FastAPI
from fastapi.responses import HTMLResponse, JSONResponse
from pydantic import Field
from starlette.requests import Request
from starlette.types import ASGIApp, Receive, Scope, Send

from armtwin.models.catalogue.injection import taken_by
from armtwin.models.catalogue.registry import effect_named
from armtwin.models.errors import ArmtwinError, InputError
from armtwin.models.validation import Strict
from armtwin.scenarios.classes.answer import NOTHING, Answer
from armtwin.scenarios.classes.class_file import Student
from armtwin.scenarios.classes.course import Course
from armtwin.scenarios.classes.draw import token
from armtwin.scenarios.classes.seat import Seat
from armtwin.scenarios.serving.access import Guard, new_token, route_of
from armtwin.scenarios.serving.app import PAGE as LIVE_PAGE
from armtwin.scenarios.serving.app import add_entrance, build_app, page_files, tell_errors
from armtwin.scenarios.serving.pace import Pace

PAGE = Path(__file__).parent / "page"
# Calibrations and diagnoses of all students that may run at a time.
_JOBS = 2
# Nobody needs more, and each is kept.
_MOST_ANSWERS = 200
# Longer than any draw on a machine that has time.
_DRAWING_S = 4.0


class Grant(Strict):
    """What an instructor grants a robot: days, pictures, or a fresh one."""

    robot: Annotated[str, Field(max_length=60)]
    what: Literal["days", "pictures", "fresh"]
    amount: Annotated[float, Field(ge=-1000, le=1000)] = 1.0


class ClassApp:
    """ASGI: hands each request to the bench of the student whose token it carries.

    Everybody else, with whatever name in the address, sees one and the same lobby: the roster is nobody's business, and
    no bench is drawn for a stranger.
    """

    def __init__(self, course: Course, hosts: tuple[str, ...] | None) -> None:
        self._course, self._hosts = course, hosts
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="benches")
        slots = threading.BoundedSemaphore(_JOBS)
        robots = dict.fromkeys(student.robot for student in course.group.students)
        self.seats = {robot: Seat(course, robot, self._thread, slots) for robot in robots}
        self._students = {student.id: student for student in course.group.students}
        self._drawing = ThreadPoolExecutor(2, thread_name_prefix="drawing")
        self._apps: dict[str, tuple[int, ASGIApp]] = {}
        self._waiting: dict[str, Future[ASGIApp]] = {}
        self._building = {student.id: threading.Lock() for student in course.group.students}
        self._prepared, self._ended = threading.Event(), threading.Event()
        self._lobby = _lobby(hosts)
        self._front = self._build_front()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve a request."""
        words = route_of(scope).split("/", 3) if scope["type"] == "http" else []
        if len(words) < 4 or words[1] != "s":
            await self._front(scope, receive, send)
            return
        inner = {**scope, "root_path": f"{scope.get('root_path', '')}/s/{words[2]}"}
        guard = Guard(self._lobby, token(self._course.group, words[2]), self._hosts)
        student = self._students.get(words[2])
        app = self._lobby
        if guard.allows(Request(inner)) and student is not None:
            ready = self._ready(student)
            # Drawn by threads of their own: who has his robot does not wait for others'.
            app = await asyncio.shield(asyncio.wrap_future(self._awaited(student))) if ready is None else ready
        await app(inner, receive, send)

    def prepare(self) -> None:
        """Draw every robot beforehand; returns when all are there or the server ends."""
        for student in self._students.values():
            if self._ended.is_set():
                break
            try:
                self._app_of(student)
            except ArmtwinError as error:  # his page says that there is none; the others have theirs
                print(f"armtwin: {student.id}: {error}", file=sys.stderr)
        self._prepared.set()

    def _awaited(self, student: Student) -> Future[ASGIApp]:
        """Return the drawing of a student's robot, one for however many requests wait for it."""
        waiting = self._waiting.get(student.id)
        if waiting is None or waiting.done():
            waiting = self._waiting[student.id] = self._drawing.submit(self._drawn, student)
        return waiting

    def _drawn(self, student: Student) -> ASGIApp:
        """Return the application of a student whose robot is not drawn yet.

        A robot without a fault is drawn faster than others. So nobody is let in before all are drawn, and who is given
        a fresh one waits for a fixed time: how long it takes tells nothing.
        """
        self._prepared.wait()
        pace = Pace()
        try:
            with pace.beats(_DRAWING_S):
                app = self._app_of(student)
        except ArmtwinError:
            app = JSONResponse({"detail": "your robot cannot be drawn; tell your instructor"}, 503)
        pace.pay()
        return app

    def _ready(self, student: Student) -> ASGIApp | None:
        """Return the application of a student whose robot is drawn."""
        attempt, app = self._apps.get(student.id, (0, None))
        return app if attempt == self.seats[student.robot].attempt else None

    def _app_of(self, student: Student) -> ASGIApp:
        seat = self.seats[student.robot]
        with self._building[student.id]:
            attempt = seat.attempt
            if student.id not in self._apps or self._apps[student.id][0] != attempt:
                visit = seat.visit()
                app = build_app(visit, token(self._course.group, student.id), self._hosts)
                _add_hand_in(app, self._course, student, seat)
                self._apps[student.id] = (attempt, app)
            return self._apps[student.id][1]

    def close(self) -> None:
        """Close every bench."""
        self._ended.set()
        self._prepared.set()
        for seat in self.seats.values():
            seat.close()
        self._drawing.shutdown(cancel_futures=True)
        self._thread.shutdown()

    def _build_front(self) -> FastAPI:
        @asynccontextmanager
        async def lifespan(_: FastAPI) -> AsyncIterator[None]:
            yield
            await asyncio.to_thread(self.close)

        front = FastAPI(docs_url=None, redoc_url=None, openapi_url=None, lifespan=lifespan)

        @front.get("/")
        def index() -> HTMLResponse:
            """Say where to go."""
            return HTMLResponse("<!doctype html><title>armtwin class</title><p>Open the link on your hand-out.</p>")

        @front.get("/health")
        def health() -> dict[str, str]:
            """Say that a server is here, and which."""
            return {"armtwin": version("armtwin")}

        instructor = FastAPI(docs_url=None, redoc_url=None, openapi_url=None)
        instructor.add_middleware(Guard, token=token(self._course.group, ""), hosts=self._hosts)
        tell_errors(instructor)
        _add_instructor(instructor, self._course, self.seats)
        front.mount("/instructor", instructor)
        return front


def _lobby(hosts: tuple[str, ...] | None) -> ASGIApp:
    """What a visitor without a token sees of any address below s/: the page's outside, which says how to get in."""
    lobby = FastAPI(docs_url=None, redoc_url=None, openapi_url=None)
    lobby.add_middleware(Guard, token=new_token(), hosts=hosts)
    lobby.mount("/static", page_files(), name="static")
    add_entrance(lobby, lambda: (LIVE_PAGE / "index.html").read_text("utf-8"))
    return lobby


def _add_hand_in(app: FastAPI, course: Course, student: Student, seat: Seat) -> None:
    group = course.group

    @app.get("/hand-in", response_class=HTMLResponse, include_in_schema=False)
    def page() -> HTMLResponse:
        return HTMLResponse((PAGE / "hand_in.html").read_text("utf-8"))

    @app.get("/api/class")
    def about() -> dict[str, Any]:
        """Say what is asked, by when, what was handed in, and what the instructor has released."""
        standing = seat.standing()
        answers = course.answers(seat.robot, standing["attempt"])
        arm = seat.visit().source.description.arm
        causes = [effect_named(name) for name in sorted(group.robots.effects)]
        return {
            "title": group.title,
            "name": student.name,
            "due": group.due_of(student, course.granted(seat.robot, "days")).isoformat(),
            "now": datetime.now(UTC).isoformat(timespec="seconds"),
            "attempts": group.attempts,
            "tools": list(group.tools),
            **standing,
            "causes": [
                {
                    "name": effect.name,
                    "summary": effect.summary,
                    "where": effect.where,
                    "parameters": list(taken_by(effect.injected, arm)),
                }
                for effect in causes
            ],
            "handed_in": answers[-1] if answers else None,
            "feedback": course.feedback(student),
        }

    @app.post("/api/answer")
    def hand_in(answer: Answer) -> dict[str, Any]:
        """Hand in an answer; the last one counts."""
        if answer.cause != NOTHING and answer.cause not in group.robots.effects:
            raise InputError(f"cause: '{answer.cause}' is none of {NOTHING}, {', '.join(sorted(group.robots.effects))}")
        standing = seat.standing()
        if standing["answers"] >= _MOST_ANSWERS:
            raise InputError(f"answer: {_MOST_ANSWERS} were handed in, and no more are taken; ask your instructor")
        kept = {"by": student.id, "pictures_taken": standing["pictures_taken"], **answer.model_dump()}
        course.add_answer(seat.robot, standing["attempt"], kept)
        return {"handed_in": True, "answers": standing["answers"] + 1}

    @app.post("/api/attempt")
    def again() -> dict[str, Any]:
        """Begin another attempt, with a fresh robot and a fresh budget."""
        return {"attempt": seat.begin_another()}


def _add_instructor(app: FastAPI, course: Course, seats: dict[str, Seat]) -> None:
    add_entrance(app, lambda: (PAGE / "instructor.html").read_text("utf-8"))

    @app.get("/api/class")
    def standing() -> dict[str, Any]:
        """Say who measures, who is stuck, who has spent his budget."""
        return {
            "title": course.group.title,
            "version": version("armtwin"),
            "now": datetime.now(UTC).isoformat(timespec="seconds"),
            "students": [
                {
                    "id": student.id,
                    "name": student.name,
                    "robot": student.robot,
                    "due": course.group.due_of(student, course.granted(student.robot, "days")).isoformat(),
                    **seats[student.robot].standing(),
                }
                for student in course.group.students
            ],
        }

    @app.post("/api/grant")
    def grant(wanted: Grant) -> dict[str, bool]:
        """Extend, reset, or give more pictures."""
        if wanted.robot not in seats:
            raise InputError(f"robot: there is no robot '{wanted.robot}'")
        course.change(wanted.robot, wanted.what, wanted.amount)
        return {"granted": True}
