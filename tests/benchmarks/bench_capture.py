"""What a capture adds to each pose beyond settling, on the emulated bench.

Besides the time on the clock, which other programs on the machine lengthen, the processor time of the host's thread is
given: what is left of the overhead on an idle machine, but for the disk.

Settling ends when the picture that the pose is recorded with has arrived. Overhead is the time from there until the
next command is on its way: quality of the picture, PNG, row, flush to disk.

    python tests/benchmarks/bench_capture.py --poses 30 --out capture.json
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from armtwin.hardware.bench.bench_file import read_bench
from armtwin.hardware.bench.hardware_bench import HardwareBench
from armtwin.hardware.capture.folder import CaptureFolder
from armtwin.models import atomic
from armtwin.models.bench import Frame
from armtwin.models.plan import Plan, paper_plan
from armtwin.scenarios.emulated_bench import EmulatedBench


class TimedBench(HardwareBench):
    """Notes when each move was sent, and when settling ended."""

    def __init__(self, *arguments: object) -> None:
        super().__init__(*arguments)  # type: ignore[arg-type]
        self.sent_s: list[float] = []
        self.settled_s: list[float] = []

    def move(self, q_cmd_rad: NDArray[np.float64]) -> None:
        """Move, with the clock."""
        self.sent_s.append(time.monotonic())
        super().move(q_cmd_rad)
        self.settled_s.append(time.monotonic())


def main() -> None:
    """Run a capture and print the times."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--poses", type=int, default=30)
    parser.add_argument("--out", type=Path)
    arguments = parser.parse_args()
    with EmulatedBench() as emulated, tempfile.TemporaryDirectory() as folder:
        setup = read_bench(emulated.bench_file)
        whole = paper_plan(setup.arm)
        n = arguments.poses
        plan = Plan(whole.trajectory[:n], whole.q_cmd[:n], whole.payload_kg[:n])
        recording = CaptureFolder(Path(folder) / "recording", setup.description, plan)
        recording.open()
        parts: dict[str, list[float]] = {"quality": [], "write": [], "processor": []}
        with TimedBench(setup) as bench:
            for q in plan.q_cmd:
                bench.move(q)
                worked, started = time.thread_time(), time.monotonic()
                frame: Frame = bench.capture()
                parts["quality"].append(time.monotonic() - started)
                started = time.monotonic()
                recording.add(frame)
                parts["write"].append(time.monotonic() - started)
                parts["processor"].append(time.thread_time() - worked)
        recording.close()
    overhead_ms = 1000 * (np.array(bench.sent_s[1:]) - np.array(bench.settled_s[:-1]))
    settling_ms = 1000 * (np.array(bench.settled_s) - np.array(bench.sent_s))
    result = {
        "poses": n,
        "overhead_ms": {"median": float(np.median(overhead_ms)), "p90": float(np.percentile(overhead_ms, 90))},
        "settling_ms": {"median": float(np.median(settling_ms)), "p90": float(np.percentile(settling_ms, 90))},
        **{f"{name}_ms": {"median": 1000 * float(np.median(values))} for name, values in parts.items()},
    }
    print(json.dumps(result, indent=1))
    if arguments.out:
        atomic.write_json(arguments.out, result)


if __name__ == "__main__":
    main()
