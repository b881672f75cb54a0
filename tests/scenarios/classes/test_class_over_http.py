"""A student finds what is hidden in his robot over HTTP, within his budget; one who guesses does not."""

from __future__ import annotations

import io
import signal
import time
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest

import armtwin
from armtwin.models.arm import nominal_arm
from armtwin.models.inverse_kinematics import inverse
from armtwin.models.trajectories import LINE_END_MM, LINE_START_MM, line
from armtwin.models.wanted_path import WantedPath
from armtwin.scenarios.classes.draw import draw_robot, hidden_in, token
from armtwin.scenarios.classes.grading import grade_course
from tests.scenarios.classes.conftest import ServedClass, answered, new_course, serve

POSES, LINE = 30, 6


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ServedClass]:
    server = serve(new_course(tmp_path_factory.mktemp("class")))
    yield server
    server.process.terminate()
    server.process.wait(20)


def test_a_student_finds_the_effect_within_the_budget_and_a_guesser_does_not(served: ServedClass) -> None:
    url, key = served.bench("ada"), served.token("ada")
    with armtwin.open_bench(url, token=key) as bench:
        for q in (*_sweep(), *inverse(nominal_arm(), line(LINE_START_MM, LINE_END_MM, LINE))):
            bench.move(q)
            bench.capture()
    found = armtwin.diagnose(_recording(served, "ada"))
    _hand_in(served, "ada", _answer_of(found))
    hidden = hidden_in(draw_robot(served.course.group, "alan", 1)) or {"effect": "none"}
    guess = next(effect for effect in served.course.group.robots.effects if effect != hidden["effect"])
    _hand_in(served, "alan", answered(cause=guess, joint=2, parameter="width_rad", value=0.01, low=0.0, high=0.02))

    grades = {grade.student.id: grade for grade in grade_course(served.course)}
    assert grades["ada"].shares["cause"] == grades["ada"].shares["place"] == 1.0
    assert grades["ada"].shares["size"] == 1.0
    assert grades["ada"].shares["line"] > 0.9
    assert grades["ada"].pictures == POSES + LINE
    assert grades["ada"].total > 80.0
    assert grades["alan"].total < 40.0


def test_the_budget_ends_and_the_pictures_stay(served: ServedClass) -> None:
    with armtwin.open_bench(served.bench("grace"), token=served.token("grace")) as bench:
        bench.move(np.zeros(3))
        for _ in range(served.course.group.robots.pictures):
            bench.capture()
        with pytest.raises(armtwin.JobError, match="all pictures are taken"):
            bench.capture()
    served.course.change("team-navy", "pictures", 2)
    assert _class(served, "jean")["pictures"] == served.course.group.robots.pictures + 2
    assert len(_recording(served, "jean")) == served.course.group.robots.pictures


def test_two_tabs_of_one_student_do_not_both_move(served: ServedClass) -> None:
    with httpx.Client(base_url=served.bench("alan"), headers=served.headers("alan"), timeout=120) as tab:
        lease = tab.post("api/lease").json()["lease"]
        second = tab.post("api/lease")
        assert second.status_code == 409
        assert "somebody else" in second.json()["detail"]
        assert tab.post("api/move", json={"q_cmd_rad": [0, 0, 0]}).status_code == 409
        tab.delete("api/lease", headers={"X-Lease": lease})


def test_a_wrong_token_and_a_strangers_name_look_alike(served: ServedClass) -> None:
    for path in ("api/bench", "api/class", "api/recording.zip", "hand-in", "openapi.json"):
        wrong = httpx.get(served.bench("ada") + path, headers={"Authorization": "Bearer not-the-token"})
        other = httpx.get(served.bench("ada") + path, headers=served.headers("alan"))
        nobody = httpx.get(served.bench("nobody") + path, headers=served.headers("ada"))
        assert wrong.status_code == other.status_code == nobody.status_code == 401, path
        assert wrong.text == other.text == nobody.text
    assert httpx.get(served.bench("ada")).text == httpx.get(served.bench("nobody")).text


@pytest.mark.parametrize(
    "path",
    [
        "../../class.toml",
        "%2e%2e/%2e%2e/class.toml",
        "static/../../../../class.toml",
        "static/%2e%2e%2f%2e%2e%2fclass.toml",
        "api/jobs/1/..%2f..%2f..%2fclass.toml",
        "static//etc/passwd",
    ],
)
def test_a_path_that_climbs_gets_nothing(served: ServedClass, path: str) -> None:
    said = _raw_get(served, f"/s/ada/{path}", served.token("ada"))
    assert b"200 OK" not in said.splitlines()[0]
    assert b"secret" not in said
    assert b"root:" not in said


@pytest.mark.parametrize(
    "path",
    [
        "s/x;%20Domain=evil.example;%20Path=/;%20/?token=a",
        "s/%e2%82%ac/?token=a",
        "s/ada/?token=%e2%82%ac",
        "s/ada/?token=a%0d%0aX:1",
    ],
)
def test_an_address_puts_nothing_of_its_own_into_the_cookie(served: ServedClass, path: str) -> None:
    answer = httpx.get(f"{served.url}/{path}")
    assert answer.status_code in (303, 401)  # led to the page without its token, or told that there is none
    said = answer.headers.get("set-cookie", "")
    assert [part.split("=")[0] for part in said.split("; ")] in (
        ["armtwin_token", "HttpOnly", "Path", "SameSite"],
        [""],
    )


def test_a_page_that_loads_itself_again_gets_the_new_servers_files(served: ServedClass) -> None:
    assert httpx.get(served.bench("ada") + "static/live.js").headers["cache-control"] == "no-cache"


@pytest.mark.parametrize(
    "said",
    [
        '{"cause": "backlash", "parameter": "width_rad", "value": NaN}',
        '{"cause": "backlash", "parameter": "width_rad", "value": "much"}',
        '{"cause": "backlash", "parameter": "width_rad", "value": 1e999}',
        '{"cause": "backlash", "value": 0.1}',
        '{"cause": "backlash", "parameter": "width_rad", "value": 5, "low": 1, "high": 2}',
        '{"cause": "poltergeist"}',
        '{"cause": "none", "line_q_cmd_rad": [[0, 0], [0, 0, 0], [0, 0, 0], [0, 0, 0], [0, 0, 0]]}',
        '{"cause": "none", "truth": "please"}',
        "[]",
        "nothing",
    ],
)
def test_an_answer_that_is_none_is_refused_and_not_kept(served: ServedClass, said: str) -> None:
    before = _class(served, "grace")["answers"]
    answer = httpx.post(served.bench("grace") + "api/answer", headers=served.headers("grace"), content=said)
    assert answer.status_code == 422
    assert "Traceback" not in answer.text
    assert _class(served, "grace")["answers"] == before


def test_nothing_that_a_student_can_ask_for_holds_the_truth(served: ServedClass) -> None:
    truth = draw_robot(served.course.group, "alan", 1).truth
    numbers = [*truth["link_lengths_mm"], *truth["joint_offsets_rad"], *truth["base_in_board_mm"][:2]]
    numbers += hidden_in(draw_robot(served.course.group, "alan", 1))["parameters"].values()  # type: ignore[index]
    # A number of few digits stands in any text.
    digits = [text[:8] for text in (repr(float(number)) for number in numbers) if len(text) >= 8]
    secrets = [*digits, served.course.group.secret, 'true_bodies":{"']
    with httpx.Client(base_url=served.bench("alan"), headers=served.headers("alan"), timeout=60) as client:
        lease = {"X-Lease": client.post("api/lease").json()["lease"]}
        said = [
            client.post(path, headers=lease, json=body)
            for path, body in (
                ("api/connect", None),
                ("api/move", {"q_cmd_rad": [0.1, 0.2, -0.3]}),
                ("api/look", {}),
                ("api/move", {"q_cmd_rad": [9.0, 0, 0]}),
                ("api/hang", {"payload_kg": -1}),
                ("api/plan", {"name": "no"}),
            )
        ]
        said.append(client.put("api/faults", headers=lease, json={"faults": [{"name": "backlash"}]}))
        assert said[-1].status_code == 422
        routes = client.get("openapi.json").json()["paths"]
        said += [
            client.get(path.lstrip("/"))
            for path, methods in routes.items()
            if "get" in methods and "{" not in path and "mjpeg" not in path
        ]
        client.delete("api/lease", headers=lease)
    assert len(said) > 12
    for answer in said:
        for secret in secrets:
            assert secret not in answer.text, answer.url


def test_a_second_attempt_has_another_robot_after_an_answer(served: ServedClass) -> None:
    url, headers = served.bench("alan") + "api/attempt", served.headers("alan")
    _hand_in(served, "alan", answered(cause="none"))
    assert httpx.post(url, headers=headers, timeout=30).json() == {"attempt": 2}
    before = time.monotonic()
    assert _class(served, "alan")["pictures_taken"] == 0
    assert time.monotonic() - before >= 3.9  # how long a draw takes tells nothing of what was drawn
    assert draw_robot(served.course.group, "alan", 1).truth != draw_robot(served.course.group, "alan", 2).truth
    assert httpx.post(url, headers=headers).status_code == 422


def test_the_instructor_sees_everyone_and_a_student_does_not_see_that_page(served: ServedClass) -> None:
    url = f"{served.url}/instructor/api/class"
    key = {"Authorization": f"Bearer {token(served.course.group, '')}"}
    students = httpx.get(url, headers=key).json()["students"]
    assert [one["id"] for one in students] == ["ada", "alan", "grace", "jean"]
    assert httpx.get(url, headers=served.headers("ada")).status_code == 401
    grant = {"robot": "ada", "what": "days", "amount": 2}
    assert (
        httpx.post(f"{served.url}/instructor/api/grant", headers=served.headers("ada"), json=grant).status_code == 401
    )
    due = _class(served, "ada")["due"]
    assert httpx.post(f"{served.url}/instructor/api/grant", headers=key, json=grant).status_code == 200
    assert _class(served, "ada")["due"] > due


def test_what_was_measured_and_commanded_outlives_a_server_that_is_killed(tmp_path: Path) -> None:
    course = new_course(tmp_path)
    first = serve(course)
    try:
        bench = armtwin.open_bench(first.bench("ada"), token=first.token("ada"))
        bench.connect()
        for angle in (0.0, 0.1, 0.2):
            bench.move(np.full(3, angle))
            bench.capture()
    finally:
        first.process.send_signal(signal.SIGKILL)
        first.process.wait()
    samples = next((course.folder / "robots" / "ada" / "attempt-1").rglob("samples.csv"))
    with samples.open("a") as stream:
        stream.write("3,4.5,po")  # a row that was being written
    second = serve(course, "--root-path", "/robots")
    try:
        assert second.url.endswith("/robots")
        assert _class(second, "ada")["pictures_taken"] == 3
        with armtwin.open_bench(second.bench("ada"), token=second.token("ada")) as again:
            again.move(np.full(3, 0.3))
            again.capture()
        recording = _recording(second, "ada")
        assert len(recording) == 4
        assert (np.diff(recording.time_s) > 0).all()
        commands = course.commands("ada", 1)
        assert [one["what"] for one in commands].count("move") == 4
        page = httpx.get(f"{second.url}/s/ada/static/live.js")
        assert page.status_code == 200
    finally:
        second.process.terminate()
        second.process.wait(20)


def _sweep() -> np.ndarray[Any, Any]:
    turn = np.linspace(0.0, 2.0 * np.pi, POSES)
    return np.stack([0.35 * np.sin(3 * turn), 0.2 + 0.3 * np.sin(4 * turn + 1), -0.3 + 0.4 * np.sin(5 * turn)], axis=-1)


def _recording(served: ServedClass, student: str) -> armtwin.Recording:
    packed = httpx.get(served.bench(student) + "api/recording.zip", headers=served.headers(student), timeout=30).content
    folder = served.course.folder.parent / f"taken-home-{student}"
    zipfile.ZipFile(io.BytesIO(packed)).extractall(folder)
    return armtwin.read_recording(next(folder.iterdir()))


def _answer_of(found: armtwin.Diagnosis) -> dict[str, Any]:
    cause = found.causes[0]
    name, value, std = cause.names[0], float(cause.active.values[0]), float(cause.std[0])
    wanted = line(LINE_START_MM, LINE_END_MM, 20)
    path = WantedPath(
        np.full(20, "line"), np.zeros(20), tuple(map(str, range(20))), tip_mm=wanted[:, :2], theta_rad=wanted[:, 2]
    )
    corrected = armtwin.correct(armtwin.twin_of(found), path)
    return answered(
        cause=cause.active.effect.name,
        joint=cause.active.site.joint,
        parameter=name,
        value=value,
        low=value - 5 * std - 1e-3 * abs(value),
        high=value + 5 * std + 1e-3 * abs(value),
        line_q_cmd_rad=corrected.plan.q_cmd.tolist(),
    )


def _hand_in(served: ServedClass, student: str, answer: dict[str, Any]) -> None:
    url = served.bench(student) + "api/answer"
    assert httpx.post(url, headers=served.headers(student), json=answer, timeout=30).status_code == 200


def _class(served: ServedClass, student: str) -> dict[str, Any]:
    url = served.bench(student) + "api/class"
    return dict(httpx.get(url, headers=served.headers(student), timeout=30).json())


def _raw_get(served: ServedClass, path: str, key: str) -> bytes:
    """Send a path as it is: a client would tidy it up."""
    import socket

    host, port = served.url.removeprefix("http://").split(":")
    with socket.create_connection((host, int(port)), 10) as wire:
        wire.sendall(f"GET {path} HTTP/1.0\r\nHost: {host}\r\nAuthorization: Bearer {key}\r\n\r\n".encode())
        said = b""
        while part := wire.recv(65536):
            said += part
    return said
