"""A page in Debian's Chromium: what a person would see wrong with it."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from playwright.sync_api import Browser, Page, sync_playwright

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
DESK_PX, PHONE_PX = 1280, 390
# Without these Chromium, as root and offline, refuses to start or looks for its maker's hosts.
_ARGUMENTS = ["--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking"]
_ARGUMENTS += ["--disable-component-update", "--disable-sync"]
# Plotly draws a figure once as it is loaded and again when it knows its width.
_DRAWN = """() => [...document.querySelectorAll(".plotly-graph-div")].every(plot => {
  const drawn = plot.querySelector(".main-svg");
  return drawn && Math.abs(drawn.getBoundingClientRect().width - plot.getBoundingClientRect().width) < 1;
})"""
# A pixel of rounding at most.
_CLIPPED = """() => {
  const faults = [];
  if (document.documentElement.scrollWidth > innerWidth + 1) faults.push("the page scrolls sideways");
  for (const e of document.querySelectorAll("main *")) {
    const box = e.getBoundingClientRect();
    if (e.offsetParent && (box.right > innerWidth + 1 || box.left < -1))
      faults.push(`${e.tagName} '${(e.textContent || "").trim().slice(0, 40)}' reaches beyond the page`);
  }
  for (const plot of document.querySelectorAll(".plotly-graph-div")) {
    const frame = plot.getBoundingClientRect();
    if (!plot.querySelector(".main-svg")) faults.push("a figure is not drawn");
    for (const text of plot.querySelectorAll(".main-svg text")) {
      const box = text.getBoundingClientRect();
      if (box.width && (box.right > frame.right + 1 || box.left < frame.left - 1))
        faults.push(`'${text.textContent.slice(0, 60)}' is cut off by its figure`);
    }
    const titles = [...plot.querySelectorAll(".gtitle, .annotation-text")].map(t => t.getBoundingClientRect());
    titles.forEach((a, i) => titles.slice(i + 1).forEach(b => {
      if (a.right > b.left + 1 && b.right > a.left + 1 && a.bottom > b.top + 1 && b.bottom > a.top + 1)
        faults.push("titles of a figure overlap");
    }));
  }
  return [...new Set(faults)];
}"""


@contextmanager
def chromium() -> Iterator[Browser]:
    """Start the system's Chromium and end it afterwards."""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=_ARGUMENTS)
        try:
            yield browser
        finally:
            browser.close()


def faults_of(browser: Browser, file: Path, width_px: int) -> list[str]:
    """List what is wrong with a page at a width: clipped, not drawn, asked of the network, or said on the console."""
    context = browser.new_context(viewport={"width": width_px, "height": 900})
    page: Page = context.new_page()
    faults: list[str] = []
    page.on("request", lambda request: faults.extend(_foreign(request.url)))
    page.on("pageerror", lambda error: faults.append(f"script: {error}"))
    page.goto(file.resolve().as_uri())
    page.wait_for_function(_DRAWN)
    faults.extend(page.evaluate(_CLIPPED))
    context.close()
    return faults


def _foreign(url: str) -> list[str]:
    return [] if url.startswith(("file:", "data:", "blob:")) else [f"asks for {url}"]
