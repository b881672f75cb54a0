"""Time and held-out error of the diagnosis of a real arm's logs, joined; or of simulated logs of growing length.

    python tests/benchmarks/bench_motion.py                    # six joints' worth of rows: 1,500, 6,000, 24,000
    python tests/benchmarks/bench_motion.py LOGS               # a folder of recordings: the four named below are fitted

Times are of the process, so that a busy machine does not count.
"""

from __future__ import annotations

import csv
import json
import resource
import shutil
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from armtwin.calib.motion.diagnosis import MotionDiagnosis, diagnose_motion
from armtwin.models.recordings.moving_reader import read_moving

FITTED = ("chirp_sweep", "large_amplitude", "staircase_motion", "prbs_excitation")
PAUSE_S = 5.0


def join(logs: Path, out: Path) -> Path:
    """Write one recording of all motions of a folder, those of `FITTED` first, the others held out."""
    others = sorted(one.name for one in logs.iterdir() if (one / "samples.csv").exists() and one.name not in FITTED)
    rows, begin = [], 0.0
    for name in (*FITTED, *others):
        with (logs / name / "samples.csv").open() as file:
            header, *lines = list(csv.reader(file))
        first = float(lines[0][1])
        for line in lines:
            seen = float(line[1]) - first + begin
            rows.append([len(rows), f"{seen:.5f}", *line[2:]])
        begin = seen + PAUSE_S
    with (out / "samples.csv").open("w", newline="") as file:
        csv.writer(file).writerows([header, *rows])
    recording = json.loads((logs / FITTED[0] / "recording.json").read_text())
    (out / "recording.json").write_text(json.dumps(recording | {"held_out": others}))
    shutil.copy(logs / FITTED[0] / recording["arm"]["model"], out)
    return out


def timed(folder: Path) -> tuple[MotionDiagnosis, float]:
    """Diagnose a recording; return what was found and the processor's seconds."""
    recording = read_moving(folder)
    begin = time.process_time()
    return diagnose_motion(recording), time.process_time() - begin


def real(logs: Path) -> None:
    """Print the held-out error of each motion and joint, mrad, with the medians."""
    with tempfile.TemporaryDirectory() as folder:
        found, seconds = timed(join(logs, Path(folder)))
    motions = dict.fromkeys(one.trajectory for one in found.held_out)
    table = np.array([[1e3 * o.after_rms_rad for o in found.held_out if o.trajectory == name] for name in motions])
    for name, row in zip(motions, table, strict=True):
        print(f"{name:24}", *(f"{value:6.1f}" for value in row))
    print(f"{'median':24}", *(f"{value:6.1f}" for value in np.median(table, axis=0)))
    for cause in found.causes:
        print(cause.effect, cause.joint, *cause.equivalents)
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"{found.verdict}; {seconds:.0f} s of one core, {memory:.0f} MB")


def grown(counts: tuple[int, ...] = (1500, 6000, 24000)) -> None:
    """Print the seconds for logs of a growing number of rows, and the exponent between them."""
    from tests.support.moving import RATE_HZ, Faults, write_log

    faults = Faults({joint: {"delay": 0.03, "tau": 0.06, "friction": 0.02} for joint in range(3)})
    taken = []
    for count in counts:
        with tempfile.TemporaryDirectory() as folder:
            log = write_log(Path(folder) / "log", 4, faults, seconds=count / 4 / RATE_HZ)
            taken.append(timed(log)[1])
        print(f"{count} rows, 3 joints: {taken[-1]:.1f} s")
    slope = np.polyfit(np.log(counts), np.log(taken), 1)[0]
    print(f"exponent {slope:.2f}")


if __name__ == "__main__":
    real(Path(sys.argv[1])) if len(sys.argv) > 1 else grown()
