"""Making a recording: every pose of a plan on a bench, one picture each."""

from __future__ import annotations

from collections.abc import Callable

from armtwin.hardware.capture.folder import CaptureFolder
from armtwin.models.bench import Bench

Report = Callable[[int, int], None]


def run_capture(bench: Bench, recording: CaptureFolder, report: Report | None = None) -> None:
    """Run what is missing of the recording's plan on a connected bench; the caller closes both.

    A recording that broke off is taken up behind its last pose, which is only passed again, so that the next one is
    approached from the side that the plan wants. `report(done, of)` is called after every pose.
    """
    plan = recording.plan
    payload = 0.0
    first = recording.done
    for row in range(max(first - 1, 0), len(plan)):
        if plan.payload_kg[row] != payload:
            payload = float(plan.payload_kg[row])
            bench.hang(payload)
        bench.move(plan.q_cmd[row])
        if row < first:
            continue
        recording.add(bench.capture())
        if report is not None:
            report(recording.done, len(plan))
