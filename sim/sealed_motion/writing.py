"""Writing a sealed log as a recording of the contract; floats are written so that they read back the same."""

from __future__ import annotations

import csv
import io
from pathlib import Path

from armtwin.models import atomic
from armtwin.sim.sealed_motion.arms import MODEL_FILE
from armtwin.sim.sealed_motion.draw import SealedLog


def write_log(folder: Path, log: SealedLog) -> None:
    """Write `recording.json`, `samples.csv` and, for an arm by a model, its file into `folder`."""
    header: dict[str, object] = {"schema": "armtwin.recording/1", "motion": "moving", "arm": log.arm.table}
    if log.held_out:
        header["held_out"] = list(log.held_out)
    atomic.write_json(folder / "recording.json", header)
    if log.arm.model is not None:
        atomic.write_text(folder / MODEL_FILE, log.arm.model)
    n = range(1, log.q_meas.shape[1] + 1)
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    columns = [*(f"theta{i}_cmd_rad" for i in n), *(f"theta{i}_meas_rad" for i in n)]
    writer.writerow(["sample", "time_s", "trajectory", *columns])
    row = 0
    for motion in log.motions:
        for time_s, q_cmd in zip(motion.time_s.tolist(), motion.q_cmd.tolist(), strict=True):
            writer.writerow([row, repr(time_s), motion.name, *map(repr, q_cmd), *map(repr, log.q_meas[row].tolist())])
            row += 1
    atomic.write_text(folder / "samples.csv", out.getvalue())
