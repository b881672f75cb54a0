"""The live page in a browser: from the open page to a fault that was found."""

from __future__ import annotations

import contextlib
import json
import math
import re
import signal

import pytest
from playwright.sync_api import Page, Route
from playwright.sync_api import TimeoutError as PlaywrightTimeout

from armtwin.models.recordings.reader import read_recording
from tests.scenarios.serving.conftest import TOKEN, Served, start_server
from tests.support.browser import CHROMIUM, DESK_PX, PHONE_PX, chromium

pytestmark = [
    pytest.mark.skipif(CHROMIUM is None, reason="no Chromium on this machine"),
    pytest.mark.xdist_group("serving"),
]
FOUND_MS = 120_000


def test_somebody_puts_play_in_runs_the_circles_and_reads_that_it_was_found(served: Served) -> None:
    with chromium() as browser:
        page = browser.new_page(viewport={"width": DESK_PX, "height": 900})
        asked: list[str] = []
        broken: list[str] = []
        page.on("request", lambda request: asked.append(request.url))
        page.on("pageerror", lambda error: broken.append(str(error)))
        page.goto(f"{served.url}/?token={TOKEN}")
        page.get_by_text("the arm is yours").wait_for(timeout=FOUND_MS)
        page.get_by_label("joint 1, °", exact=True).press("ArrowRight")  # a keyboard moves it too
        page.select_option("#fault-name", "backlash")
        page.select_option("select[name=joint]", "2")
        page.fill("input[name=width_rad]", "1.5")
        page.get_by_role("button", name="Put it in").click()
        page.locator("#faults-in li").wait_for(timeout=FOUND_MS)
        for name in ("circle 25 (50)", "line (50)"):
            page.get_by_role("button", name=name).click()
            page.get_by_text(f"{name[:4]}").first.wait_for()
            page.wait_for_function(
                "name => document.getElementById('status').textContent.startsWith(name + ': 50 poses are recorded')",
                arg=name.split(" (")[0].replace(" ", "_"),
                timeout=FOUND_MS,
            )
        page.get_by_role("button", name="Diagnose").click()
        page.locator("#jobs li[data-state=done]").wait_for(timeout=FOUND_MS)
        assert "NAMED: The cause is backlash (joint 2)" in page.inner_text("#jobs")
        report = page.frame_locator("#report")
        report.get_by_role("heading", name="What is wrong").wait_for(timeout=FOUND_MS)
        assert page.inner_text("#twin-name") == "extended"
        page.set_viewport_size({"width": PHONE_PX, "height": 800})
        assert page.evaluate("document.documentElement.scrollWidth") <= PHONE_PX
        assert all(url.startswith((served.url, "data:", "blob:")) for url in asked)
        assert broken == []


def test_a_page_without_the_token_says_where_to_get_it(served: Served) -> None:
    with chromium() as browser:
        page = browser.new_page()
        page.goto(served.url)
        page.get_by_text("open it by the link that armtwin serve printed").wait_for()


def test_what_was_recorded_outlives_a_server_that_is_killed(tmp_path) -> None:  # type: ignore[no-untyped-def]
    server = start_server(tmp_path / "out")
    with chromium() as browser:
        page = browser.new_page()
        page.goto(f"{server.url}/?token={TOKEN}")
        page.get_by_text("the arm is yours").wait_for(timeout=FOUND_MS)
        page.get_by_role("button", name="line (50)").click()
        page.wait_for_function("Number(document.getElementById('misses-text').textContent.split(' ')[0]) >= 5")
        server.process.send_signal(signal.SIGKILL)
        server.process.wait()
    assert len(read_recording(tmp_path / "out" / "recordings" / "recording-001")) >= 4


def test_a_page_left_open_over_another_version_of_the_server_says_so_and_loads_itself_again(served: Served) -> None:
    with chromium() as browser:
        page = browser.new_page()
        _open(page, served)
        loads: list[str] = []
        page.on("load", lambda: loads.append(page.url))

        def of_another_version(route: Route) -> None:
            answer = route.fetch()
            if not loads:
                answer = {"status": 200, "body": json.dumps({**answer.json(), "version": "9.9.9"})}  # type: ignore[assignment]
                route.fulfill(**answer, content_type="application/json")  # type: ignore[arg-type]
            else:
                route.fulfill(response=answer)

        page.route("**/api/state", of_another_version)
        page.get_by_text("the server is another version now").wait_for(timeout=FOUND_MS)
        page.wait_for_event("load", timeout=FOUND_MS)
        page.locator("#joints input").first.wait_for(timeout=FOUND_MS)
        assert not page.get_by_role("alert").is_visible()


def test_a_server_that_was_away_is_told_and_the_word_goes_when_it_is_back(served: Served) -> None:
    with chromium() as browser:
        page = browser.new_page()
        _open(page, served)
        page.route("**/api/state", lambda route: route.abort())
        page.get_by_text("the server does not answer").wait_for(timeout=FOUND_MS)
        page.unroute("**/api/state")
        page.get_by_role("alert").wait_for(state="hidden", timeout=FOUND_MS)


def test_the_keyboard_alone_types_an_angle_turns_the_view_and_keeps_its_place(served: Served) -> None:
    with chromium() as browser:
        page = browser.new_page()
        _open(page, served)
        sent: list[list[float]] = []
        page.on(
            "request", lambda one: sent.append(one.post_data_json["q_cmd_rad"]) if one.url.endswith("move") else None
        )
        angle = page.get_by_label("joint 2, degrees")
        angle.focus()
        page.keyboard.press("Control+A")
        page.keyboard.type("-12.5")
        page.keyboard.press("Enter")
        page.wait_for_function("document.getElementById('joint-2').value === '-12.5'")
        page.wait_for_timeout(500)
        assert [round(math.degrees(q[1]), 2) for q in sent] == [-12.5]  # neither 0 nor -1 on the way
        page.locator("#space").focus()
        before = page.locator("#space").screenshot()
        for _ in range(5):
            page.keyboard.press("ArrowLeft")
        assert page.locator("#space").screenshot() != before
        page.select_option("#fault-name", "servo_gain")
        page.get_by_role("button", name="Put it in").press("Enter")
        fault = page.locator("#faults-in li").filter(has_text=re.compile("servo.gain"))
        out = fault.get_by_role("button", name="take out")
        out.focus()
        page.wait_for_timeout(2500)  # the state is asked for every second
        assert page.evaluate("document.activeElement.textContent") == "take out"
        out.press("Enter")
        fault.wait_for(state="detached", timeout=FOUND_MS)


def test_whatever_can_be_operated_has_a_name_for_a_screen_reader(served: Served) -> None:
    with chromium() as browser:
        page = browser.new_page()
        _open(page, served)
        nameless = page.evaluate(
            """() => [...document.querySelectorAll(
                "button, input, select, textarea, a[href], canvas, iframe, svg[role]")]
            .filter(one => !(one.getAttribute("aria-label") || one.title
                || one.textContent.trim() || one.labels?.length))
            .map(one => one.outerHTML)"""
        )
        assert nameless == []


def _open(page: Page, served: Served) -> None:
    page.goto(f"{served.url}/?token={TOKEN}")
    page.locator("#joints input").first.wait_for(timeout=FOUND_MS)
    take = page.get_by_role("button", name="Take the arm")
    page.wait_for_function("document.getElementById('status').textContent !== 'connecting …'", timeout=FOUND_MS)
    for _ in range(10):  # the page takes the arm itself where nobody has it
        page.wait_for_timeout(1500)
        if page.locator("#joint-1:enabled").is_visible():
            break
        if take.is_visible():
            with contextlib.suppress(PlaywrightTimeout):
                take.click(timeout=1000)
    page.locator("#joint-1:enabled").wait_for(timeout=FOUND_MS)
