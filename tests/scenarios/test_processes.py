"""A worker whose parent is killed ends too, whatever it is doing."""

import subprocess
import sys
from pathlib import Path

# The worker holds the parent's standard output open as long as it lives.
PROGRAM = """
import multiprocessing
from armtwin.scenarios.processes import end_with_parent

def work():
    end_with_parent()
    print("at work", flush=True)
    while True:
        sum(range(1000))

if __name__ == "__main__":
    worker = multiprocessing.get_context("spawn").Process(target=work)
    worker.start()
    worker.join()
"""
PATIENCE_S = 20.0  # only a failing test waits so long


def test_a_worker_deep_in_its_work_ends_when_its_parent_is_killed(tmp_path: Path):
    program = tmp_path / "program.py"
    program.write_text(PROGRAM)
    with subprocess.Popen([sys.executable, str(program)], stdout=subprocess.PIPE, text=True) as parent:
        assert parent.stdout is not None
        assert parent.stdout.readline() == "at work\n"

        parent.kill()

        parent.communicate(timeout=PATIENCE_S)  # until nobody holds the output open
