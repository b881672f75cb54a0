"""How long a diagnosis takes on one core: `python tests/benchmarks/bench_diagnosis.py [effect ...]`.

500 poses, four markers, the whole catalogue; then 125 to 1000 poses for the growth, many poses with re-simulation and
report, and where the time goes. Targets: 10 s for 500 poses, linear in poses; with re-simulation and report 10 s for
2,000 poses and 40 s for 8,000. Times are CPU time, so that a busy machine does not count. Ends with 1 if missed.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # one core is what is measured

import cProfile
import pstats
import sys
import tempfile
import time
from itertools import pairwise
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import numpy as np

from armtwin.calib.diagnosis.diagnosis import Diagnosis, diagnose
from armtwin.calib.diagnosis.experiment import propose
from armtwin.models.catalogue.registry import catalogue
from armtwin.models.recordings.recording import Recording
from armtwin.scenarios.diagnosis.pipeline import report_on, write_report
from armtwin.sim.sealed import draw_world

ROOT = Path(__file__).resolve().parents[2]
TARGET_S = 10.0
POSES = 500
GROWTH = (125, 250, 500, 1000)
# Doubling the poses may take this much longer: twice, and what timing and the draw of another world scatter.
MOST_GROWTH = 2.6
# Poses, and seconds that one cause may take with re-simulation and report.
MANY = {2000: 10.0, 8000: 40.0}
# None: the gate alone. The others are the usual case, one with a long scan, and two causes at once.
CASES: dict[str, tuple[str, ...]] = {
    "nothing": (),
    "backlash": ("backlash",),
    "camera_moved": ("camera_moved",),
    "joint_slip": ("joint_slip",),
    "gravity_sag": ("gravity_sag",),
    "quantization": ("quantization",),
    "two causes": ("backlash", "camera_moved"),
}
_LINES = 14


def recording(effects: tuple[str, ...], n_poses: int) -> Recording:
    """A sealed world with all markers, by a fixed seed."""
    rng = np.random.default_rng(7)
    markers = ("a", "b", "c", "f")
    return draw_world(rng, effects, "medium", n_poses=n_poses, noise_px=0.1, markers=markers).recording


def timed(data: Recording) -> tuple[float, float, Diagnosis]:
    """CPU seconds of a diagnosis and of the design of the next experiment, and the diagnosis."""
    start = time.process_time()
    found = diagnose(data)
    diagnosed = time.process_time()
    propose(found)
    return diagnosed - start, time.process_time() - diagnosed, found


def whole(data: Recording) -> float:
    """CPU seconds from a recording to its written report."""
    start = time.process_time()
    with tempfile.TemporaryDirectory() as folder:
        write_report(Path(folder), "bench", report_on(data))
    return time.process_time() - start


def many() -> bool:
    """Print the times for many poses and how they grow; return whether all targets are met."""
    print("many poses (backlash), from the recording to the written report:")
    times = {n: whole(recording(("backlash",), n)) for n in MANY}
    for n, seconds in times.items():
        print(f"  {n:5d} poses {seconds:6.2f} s (target {MANY[n]:g})")
    slope = np.polyfit(np.log(list(times)), np.log(list(times.values())), 1)[0]
    print(f"  time grows as poses to the power {slope:.2f}")
    return all(seconds <= MANY[n] for n, seconds in times.items())


def profile(data: Recording) -> str:
    """The functions of this project in which a diagnosis spends most, callees included."""
    profiler = cProfile.Profile()
    profiler.runcall(diagnose, data)
    stats = pstats.Stats(profiler)
    total = max(row[3] for row in stats.stats.values())  # type: ignore[attr-defined]
    rows = []
    for (file, _, name), (_, calls, own, whole, _) in stats.stats.items():  # type: ignore[attr-defined]
        path = Path(file)
        if path.is_relative_to(ROOT) and ".venv" not in path.parts:
            rows.append((whole, own, calls, f"{path.relative_to(ROOT)}:{name}"))
    rows.sort(reverse=True)
    lines = [
        f"  {100 * w / total:5.1f} %  own {100 * o / total:5.1f} %  {c:7d} calls  {n}" for w, o, c, n in rows[:_LINES]
    ]
    return "\n".join(lines)


def main(wanted: list[str]) -> int:
    """Print the times; return 0 if the targets are met."""
    catalogue()  # loading the effects is no part of a diagnosis
    cases = {name: CASES.get(name, (name,)) for name in wanted} if wanted else CASES
    worst = 0.0
    print(f"{POSES} poses, {len(catalogue())} effects, one core, CPU seconds (target {TARGET_S:g}):")
    for name, effects in cases.items():
        seconds, designing, found = timed(recording(effects, POSES))
        worst = max(worst, seconds)
        causes = " + ".join(cause.active.label for cause in found.causes)
        print(f"  {name:14s} {seconds:6.2f}   next experiment {designing:5.2f}   {found.verdict} {causes}")
    print("growth with the number of poses (backlash):")
    times = []
    for n in GROWTH:
        seconds, _, _ = timed(recording(("backlash",), n))
        times.append(seconds)
        print(f"  {n:5d} poses {seconds:6.2f} s   {1000 * seconds / n:6.2f} ms a pose")
    slope = float(np.polyfit(np.log(GROWTH), np.log(times), 1)[0])
    print(f"  time grows as poses to the power {slope:.2f}")
    print("where the time goes (backlash, profiled):")
    print(profile(recording(("backlash",), POSES)))
    quick = many()
    steepest = max(b / a for a, b in pairwise(times))
    return 0 if worst <= TARGET_S and steepest <= MOST_GROWTH and quick else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
