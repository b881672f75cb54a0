"""A student's and the instructor's pages in a browser."""

from __future__ import annotations

import re
import socket
from collections.abc import Iterator

import httpx
import pytest

from armtwin.scenarios.classes.draw import token
from tests.scenarios.classes.conftest import ServedClass, new_course, serve
from tests.support.browser import CHROMIUM, PHONE_PX, chromium

WAIT_MS = 120_000


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ServedClass]:
    server = serve(new_course(tmp_path_factory.mktemp("class")))
    yield server
    server.process.terminate()
    server.process.wait(20)


@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium on this machine")
def test_a_student_takes_a_picture_and_hands_in_on_a_phone_and_the_instructor_sees_it(served: ServedClass) -> None:
    pictures = served.course.group.robots.pictures
    with chromium() as browser:
        page = browser.new_page(viewport={"width": PHONE_PX, "height": 800})
        broken: list[str] = []
        page.on("pageerror", lambda error: broken.append(str(error)))
        page.goto(f"{served.bench('ada')}?token={served.token('ada')}")
        page.get_by_text("the arm is yours").wait_for(timeout=WAIT_MS)
        assert served.token("ada") not in page.url
        page.get_by_role("button", name="Take a picture here").click()
        page.get_by_text(f"{pictures - 1} pictures left").wait_for(timeout=WAIT_MS)
        assert not page.get_by_text("truth (a simulation knows it)").is_visible()
        page.get_by_role("link", name="Hand in your answer").click()
        page.locator("#cause option").nth(2).wait_for(state="attached")
        page.select_option("#cause", "backlash")
        page.get_by_label("Joint or link").fill("2")
        page.get_by_role("button", name="Hand in").click()
        page.get_by_text(re.compile("the last: backlash")).wait_for()
        assert page.evaluate("document.documentElement.scrollWidth") <= PHONE_PX
        page.goto(f"{served.url}/instructor/?token={token(served.course.group, '')}")
        page.get_by_text("handed in").wait_for()
        page.get_by_label("+20 pictures for Ada Lovelace").click()
        page.get_by_text(f"1 of {pictures + 20}").wait_for()
        assert broken == []


def test_a_client_that_sends_slowly_or_not_at_all_holds_nobody_up(served: ServedClass) -> None:
    host, port = served.url.removeprefix("http://").split(":")
    slow = [socket.create_connection((host, int(port)), 10) for _ in range(40)]
    try:
        head = f"POST /s/ada/api/answer HTTP/1.1\r\nHost: {host}\r\nAuthorization: Bearer {served.token('ada')}\r\n"
        for wire in slow:
            wire.sendall(f"{head}Content-Length: 100000\r\n\r\n{{".encode())
        assert httpx.get(served.bench("alan") + "api/class", headers=served.headers("alan"), timeout=20).is_success
    finally:
        for wire in slow:
            wire.close()
