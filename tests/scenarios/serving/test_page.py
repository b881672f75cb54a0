"""The live page in a browser: from the open page to a fault that was found."""

from __future__ import annotations

import signal

import pytest

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
