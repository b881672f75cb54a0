"""How many pictures a second does the live page show of the simulated bench, and what takes the time of one?

PYTHONPATH=. python tests/benchmarks/bench_live_page.py
"""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from armtwin.scenarios.serving.live_bench import LiveBench
from armtwin.scenarios.serving.shot import Shot
from armtwin.scenarios.serving.sources import source_of
from tests.scenarios.serving.conftest import TOKEN, start_server
from tests.support.browser import chromium

SECONDS, POSES = 15.0, 40
# Moves a slider to and fro as a hand does, sixty times a second, and counts the pictures that the page shows.
DRAG = """async seconds => {
  const slider = document.getElementById("joint-1"), picture = document.getElementById("picture");
  let shown = 0;
  picture.addEventListener("load", () => { shown += 1; });
  const began = performance.now();
  while (performance.now() - began < 1000 * seconds) {
    slider.value = 20 * Math.sin((performance.now() - began) / 500);
    slider.dispatchEvent(new Event("input"));
    await new Promise(requestAnimationFrame);
  }
  return shown;
}"""


def main() -> None:
    """Time the parts of a picture in one process, then the whole chain in a browser."""
    _parts()
    with tempfile.TemporaryDirectory() as folder, chromium() as browser:
        served = start_server(Path(folder))
        try:
            page = browser.new_page(viewport={"width": 1280, "height": 900})
            page.goto(f"{served.url}/?token={TOKEN}")
            page.get_by_text("the arm is yours").wait_for(timeout=60_000)
            shown = page.evaluate(DRAG, SECONDS)
        finally:
            served.process.terminate()
            served.process.wait(20)
    print(f"a slider dragged for {SECONDS:.0f} s in Chromium: {shown / SECONDS:.1f} pictures a second shown")
    print(f"load of the machine {os.getloadavg()[0]:.1f}, {os.cpu_count()} cores")


def _parts() -> None:
    spent: dict[str, float] = {}

    def timed(name: str, work: Callable[..., Any]) -> Callable[..., Any]:
        def run(*args: Any, **options: Any) -> Any:
            began = time.perf_counter()
            try:
                return work(*args, **options)
            finally:
                spent[name] = spent.get(name, 0.0) + time.perf_counter() - began

        return run

    with tempfile.TemporaryDirectory() as folder:
        live = LiveBench(source_of("simulated"), Path(folder))
        live.connect()
        live.move(np.zeros(3))
        live.capture()  # compiles the shaders
        bench: Any = live._bench  # its parts are what is timed
        bench.move, bench.capture = timed("move", bench.move), timed("picture", bench.capture)
        live._find = timed("markers", live._find)  # type: ignore[method-assign]
        began = time.perf_counter()
        for pose in range(POSES):
            live.approach(np.array([0.3 * np.sin(pose / 3), 0.0, 0.0]))
            shot: Shot = live.capture()
            timed("jpeg", lambda shot=shot: shot.jpeg)()
        total = time.perf_counter() - began
        live.shut_down()
    parts = ", ".join(f"{name} {1e3 * seconds / POSES:.0f} ms" for name, seconds in spent.items())
    print(f"one pose after the other in one process: {POSES / total:.1f} a second ({parts})")


if __name__ == "__main__":
    main()
