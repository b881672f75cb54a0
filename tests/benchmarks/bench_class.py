"""Thirty students, a picture every ten seconds each: how long does each wait, and is the pace kept?

PYTHONPATH=. python tests/benchmarks/bench_class.py
"""

from __future__ import annotations

import os
import tempfile
import threading
import time
from pathlib import Path

import httpx
import numpy as np

import armtwin
from tests.scenarios.classes.conftest import ServedClass, new_course, serve

STUDENTS, EVERY_S, SECONDS = 30, 10.0, 60.0

HEAD = """
schema = "armtwin.class/1"
title = "Thirty"
secret = "thirty students at two cores"
due = 2099-12-11T23:59:00+01:00
"""
CLASS = HEAD + "".join(f'[[students]]\nid = "s{number}"\nname = "Student {number}"\n' for number in range(STUDENTS))


def main() -> None:
    """Serve a class and let everybody measure."""
    firsts: list[float] = []
    waits: list[float] = []
    with tempfile.TemporaryDirectory() as folder:
        served = serve(new_course(Path(folder), CLASS))
        try:
            began = time.monotonic()
            for number in range(STUDENTS):  # when the last one answers every robot is drawn
                httpx.get(f"{served.bench(f's{number}')}api/state", headers=served.headers(f"s{number}"), timeout=300)
            print(f"{STUDENTS} robots drawn in {time.monotonic() - began:.0f} s")
            before_s = _cpu_s(served.process.pid)
            threads = [
                threading.Thread(target=_student, args=(served, number, firsts, waits)) for number in range(STUDENTS)
            ]
            for thread in threads:
                thread.start()
            for thread in threads:
                thread.join()
            cpu_s = _cpu_s(served.process.pid) - before_s
            memory = Path(f"/proc/{served.process.pid}/statm").read_text().split()[1]
        finally:
            served.process.terminate()
            served.process.wait(20)
    half, most = np.percentile(waits, [50, 95])
    mib = int(memory) * os.sysconf("SC_PAGESIZE") / 2**20
    print(
        f"the first picture, for which a bench is opened: median {np.median(firsts):.2f} s, longest {max(firsts):.2f} s"
    )
    print(f"{len(waits)} more pictures of {STUDENTS} students, one every {EVERY_S:.0f} s each")
    print(f"move and picture: median {half:.2f} s, 95 % below {most:.2f} s, longest {max(waits):.2f} s")
    print(f"{cpu_s / (len(waits) + len(firsts)):.3f} s of one core a picture")
    print(f"server: {mib:.0f} MiB; load of the machine {os.getloadavg()[0]:.1f}")


def _cpu_s(pid: int) -> float:
    """Seconds that a process has computed, which other programs on the machine do not change much."""
    words = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(words[11]) + int(words[12])) / os.sysconf("SC_CLK_TCK")


def _student(served: ServedClass, number: int, firsts: list[float], waits: list[float]) -> None:
    name, rng = f"s{number}", np.random.default_rng(number)
    time.sleep(number * EVERY_S / STUDENTS)
    with armtwin.open_bench(served.bench(name), token=served.token(name)) as bench:
        until, bench_is_open = time.monotonic() + SECONDS, False
        while time.monotonic() < until:
            before = time.monotonic()
            bench.move(rng.uniform(-0.3, 0.3, 3))
            bench.capture()
            took = time.monotonic() - before
            (waits if bench_is_open else firsts).append(took)
            bench_is_open = True
            time.sleep(max(0.0, EVERY_S - took))


if __name__ == "__main__":
    main()
