"""`armtwin lab list` and `armtwin lab open`, as a student uses them."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

from armtwin.scenarios.labs.shelf import LABS, students_copy
from tests.support.browser import CHROMIUM, chromium


def test_the_list_names_every_lab() -> None:
    said = _armtwin("lab", "list").stdout
    assert all(f" {lab.number} " in said and lab.title in said for lab in LABS)


def test_a_lab_that_there_is_not_is_one_line() -> None:
    done = _armtwin("lab", "open", "99")
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert "there is no lab 99" in done.stderr


def test_a_students_own_copy_is_never_overwritten(tmp_path: Path) -> None:
    path = students_copy(LABS[0], tmp_path)
    path.write_text("# what I wrote", "utf-8")
    assert students_copy(LABS[0], tmp_path).read_text("utf-8") == "# what I wrote"


@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium here")
def test_a_lab_opens_as_a_page_that_works_and_asks_the_network_for_nothing(tmp_path: Path) -> None:
    words = [sys.executable, "-m", "armtwin", "lab", "open", "4", "--no-browser", "--folder", str(tmp_path)]
    process = subprocess.Popen(words, stdout=subprocess.PIPE, text=True)
    try:
        assert process.stdout is not None
        url = next(found[0] for line in process.stdout if (found := re.search(r"http://\S+", line)))
        foreign: list[str] = []
        with chromium() as browser:
            page = browser.new_page()
            page.on("request", lambda request: foreign.extend(_beyond(request.url)))
            page.goto(url)
            open_checks = page.locator("[role=status]", has_text="open")
            open_checks.first.wait_for(timeout=30_000)
            page.frame_locator("iframe").locator("svg").first.wait_for(timeout=30_000)
        assert foreign == []
    finally:
        process.terminate()
        process.wait(20)


def _armtwin(*words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, "-m", "armtwin", *words], capture_output=True, text=True, check=False)


def _beyond(url: str) -> list[str]:
    return [] if url.startswith(("http://localhost:", "http://127.0.0.1:", "data:", "blob:")) else [url]
