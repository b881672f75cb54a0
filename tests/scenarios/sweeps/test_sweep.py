"""A sweep in real processes: the same bytes however it was broken off, and a scheduler of somebody else's."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from armtwin.models.recordings.reader import read_recording
from armtwin.scenarios.sweeps.journal import JOURNAL, RESULTS
from armtwin.scenarios.sweeps.sweep import sweep
from armtwin.scenarios.sweeps.table import read_sweep

pytestmark = pytest.mark.xdist_group("sweep")

_TABLE = """
schema = "armtwin.sweep/1"
seed = 5
trials = 8
[factors]
effects = ["joint_slip"]
poses = [24]
noise_px = [0.1]
"""
_WAIT_S = 120.0


@pytest.fixture(scope="module")
def table(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("table") / "sweep.toml"
    path.write_text(_TABLE, "utf-8")
    return path


@pytest.fixture(scope="module")
def whole(table: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("whole")
    sweep(read_sweep(table), out, workers=2)
    return out


def _command(table: Path, out: Path, *more: str) -> list[str]:
    return [sys.executable, "-m", "armtwin", "sweep", str(table), "--out", str(out), *more]


def _wait_for_lines(path: Path, lines: int) -> None:
    end = time.monotonic() + _WAIT_S
    while not path.exists() or path.read_bytes().count(b"\n") < lines:
        assert time.monotonic() < end
        time.sleep(0.05)


def test_every_world_has_a_row_that_other_programs_read(whole: Path) -> None:
    rows = pq.read_table(whole / RESULTS).to_pylist()
    assert len(rows) == 8
    assert [(row["cell"], row["trial"]) for row in rows] == sorted((row["cell"], row["trial"]) for row in rows)
    assert [row["found"] for row in sorted(rows, key=lambda row: row["size"])][:2] == [False] * 2
    assert any(row["found"] for row in rows)


def test_a_killed_sweep_goes_on_and_ends_with_the_same_bytes(table: Path, whole: Path, tmp_path: Path) -> None:
    with subprocess.Popen(_command(table, tmp_path / "out"), stderr=subprocess.DEVNULL, start_new_session=True) as run:
        _wait_for_lines(tmp_path / "out" / JOURNAL, 4)
        os.kill(run.pid, signal.SIGKILL)
    journal = tmp_path / "out" / JOURNAL
    kept = journal.read_bytes()
    journal.write_bytes(kept + b'{"cell":0,"tri')  # as a disk that was full leaves it
    sweep(read_sweep(table), tmp_path / "out", workers=2)
    assert journal.read_bytes().startswith(kept)
    assert (tmp_path / "out" / RESULTS).read_bytes() == (whole / RESULTS).read_bytes()


def test_a_sweep_made_in_pieces_ends_with_the_same_bytes(table: Path, whole: Path, tmp_path: Path) -> None:
    assert len(sweep(read_sweep(table), tmp_path, workers=1, at_most=3).rows) == 3
    sweep(read_sweep(table), tmp_path, workers=1)
    assert (tmp_path / RESULTS).read_bytes() == (whole / RESULTS).read_bytes()


def test_one_world_can_be_made_again_and_read(table: Path, whole: Path) -> None:
    done = subprocess.run(_command(table, whole, "--world", "0/3"), capture_output=True, text=True, check=True)
    assert "worlds/0-3" in done.stdout
    row = next(row for row in pq.read_table(whole / RESULTS).to_pylist() if (row["cell"], row["trial"]) == (0, 3))
    assert len(read_recording(whole / "worlds" / "0-3")) == row["n_poses"]


@pytest.mark.slow
def test_workers_and_a_scheduler_that_die_cost_no_world(table: Path, whole: Path, tmp_path: Path) -> None:
    address = "tcp://127.0.0.1:18786"

    def start(*command: str, folder: Path) -> subprocess.Popen[bytes]:
        folder.mkdir(exist_ok=True)
        return subprocess.Popen(
            [sys.executable, "-m", "distributed.cli.dask_" + command[0], *command[1:]],
            cwd=folder,
            stderr=subprocess.DEVNULL,
            env={**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"},
        )

    def scheduler() -> subprocess.Popen[bytes]:
        return start("scheduler", "--host", "127.0.0.1", "--port", "18786", "--no-dashboard", folder=tmp_path / "s")

    def worker(name: str) -> subprocess.Popen[bytes]:
        more = ("--nthreads", "1", "--no-nanny", "--no-dashboard", "--death-timeout", "60")
        return start("worker", address, *more, folder=tmp_path / name)

    running = [scheduler(), worker("w1"), worker("w2")]
    time.sleep(8.0)
    with subprocess.Popen(_command(table, tmp_path / "out", "--scheduler", address)) as client:
        try:
            _wait_for_lines(tmp_path / "out" / JOURNAL, 3)
            running[1].kill()
            _wait_for_lines(tmp_path / "out" / JOURNAL, 5)
            running[0].kill()
            running[0].wait()
            running += [scheduler(), worker("w3"), worker("w4")]
            assert client.wait(timeout=_WAIT_S) == 0
        finally:
            client.kill()
            for process in running:
                process.kill()
                process.wait()
    assert (tmp_path / "out" / RESULTS).read_bytes() == (whole / RESULTS).read_bytes()
