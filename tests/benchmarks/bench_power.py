"""How long the power of a plan takes on one core: `python tests/benchmarks/bench_power.py [effect ...]`.

The paper's 150 poses, a noise of 0.06 px, every effect at every place. Target: a minute of one core for all of them.
Times are CPU time, so that a busy machine does not count. Ends with 1 if missed.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # one core is what is measured

import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from armtwin.models.arm import nominal_arm
from armtwin.models.plan import paper_plan
from armtwin.scenarios.power.power import FORMS, Task, run_task
from armtwin.scenarios.power.setting import Setting
from armtwin.scenarios.power.words import amount, label
from armtwin.sim.sealed import sealed_effects

TARGET_S = 60.0
NOISE_PX = 0.06


def main(names: list[str]) -> int:
    """Work out the effects one after the other in this process."""
    arm = nominal_arm()
    setting = Setting(paper_plan(arm), NOISE_PX, arm.marker_names)
    total = 0.0
    for name in names or sealed_effects():
        start = time.process_time()
        places = run_task(Task("benchmark", setting, name, 0, FORMS))
        spent = time.process_time() - start
        total += spent
        told = ", ".join(f"{label(one.effect, one.site)} {amount(one.size_90, one.unit)}" for one in places)
        print(f"{spent:6.2f} s  {told}", flush=True)
    print(f"{total:6.1f} s in all, {TARGET_S:.0f} s wanted for all effects")
    return int(total > TARGET_S)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
