"""Somebody else's arm, logged by somebody else's program: from `armtwin import` to what `diagnose` says of it."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from armtwin.scenarios.cli import main
from tests.support.strangers import COUNT_RAD, JOINTS, Stream, streams, usual

Array = NDArray[np.float64]
N = 2
LOW, HIGH = np.array([720, 800]), np.array([3400, 3300])  # of each joint's range, counts


@pytest.fixture(scope="module")
def motions() -> list[Stream]:
    """Return four motions of the first two joints: lag of 60 and 90 ms, friction, about 50 ms of latency."""
    return streams(usual(N), seconds=4.0)


def counts(motions: list[Stream], folder: Path) -> list[str]:
    """A CSV of raw counts whose columns say no unit, every motion's clock its own."""
    path = folder / "log.csv"
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["time_ms", "run", *(f"{j} goal" for j in JOINTS[:N]), *(f"{j} pos" for j in JOINTS[:N])])
        for one in motions:
            for time, sent, read in zip(one.time_s - one.time_s[0], one.sent, one.read, strict=True):
                cells = (2048 + np.append(sent, read) / COUNT_RAD).round().astype(int)
                writer.writerow([f"{1e3 * time:.2f}", one.name, *cells])
    return ["csv", str(path), "--yes"]


def sage(motions: list[Stream], folder: Path) -> list[str]:
    """A folder of SAGE motions, times in µs of the Unix clock."""
    for one in motions:
        own = folder / "sage" / one.name
        own.mkdir(parents=True)
        (own / "joint_list.txt").write_text("\n".join(JOINTS[:N]) + "\n")
        stamps = [f"{1e6 * (1_764_000_000 + time):.1f}" for time in one.time_s]
        for name, head, kind, values in (
            ("control.csv", "type,timestamp,positions", "CONTROL", one.sent),
            ("state_motor.csv", "type,timestamp,positions,velocities,torques", "STATE_MOTOR", one.read),
        ):
            extra = ',"[0.0, 0.0]","[0.0, 0.0]"' if kind == "STATE_MOTOR" else ""
            rows = [f'{kind},{t},"{q.round(6).tolist()}"{extra}' for t, q in zip(stamps, values, strict=True)]
            (own / name).write_text("\n".join([head, *rows]) + "\n")
    return ["sage", str(folder / "sage")]


def lerobot(motions: list[Stream], folder: Path) -> list[str]:
    """A LeRobot data set in -100 to 100 of each joint's range, an episode a motion, its clock made of row numbers."""
    pyarrow = pytest.importorskip("pyarrow")
    parquet = pytest.importorskip("pyarrow.parquet")
    root = folder / "set"
    data = root / "data" / "chunk-000"
    data.mkdir(parents=True)
    (root / "meta").mkdir()
    names = [f"{joint}.pos" for joint in JOINTS[:N]]
    info = {
        "codebase_version": "v2.1",
        "fps": 50,
        "data_path": "data/chunk-{episode_chunk:03d}/episode_{episode_index:06d}.parquet",
        "features": {key: {"dtype": "float32", "names": names} for key in ("observation.state", "action")},
    }
    (root / "meta" / "info.json").write_text(json.dumps(info))
    for episode, one in enumerate(motions):
        number = np.arange(len(one.time_s))

        def shares(q: Array) -> list[Array]:
            at = (LOW + HIGH) // 2 + np.trunc(q / COUNT_RAD)
            return list(((at - LOW) / (HIGH - LOW) * 200.0 - 100.0).astype(np.float32))

        columns = {
            "observation.state": shares(one.read),
            "action": shares(one.sent),
            "timestamp": (number / 50).astype(np.float32),
            "frame_index": number,
            "episode_index": np.full(len(number), episode),
        }
        parquet.write_table(pyarrow.table(columns), data / f"episode_{episode:06d}.parquet")
    return ["lerobot", str(root), "--unit", "range"]


@pytest.mark.parametrize("source", [counts, sage, pytest.param(lerobot, marks=pytest.mark.slow)])
def test_a_strangers_log_is_brought_in_and_diagnosed(
    motions: list[Stream],
    source: Callable[[list[Stream], Path], list[str]],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    for arguments in (
        ["import", *source(motions, tmp_path), "--out", str(tmp_path / "log")],
        ["diagnose", str(tmp_path / "log"), "--out", str(tmp_path / "found")],
    ):
        with pytest.raises(SystemExit) as left:
            main(arguments)
        said = capsys.readouterr()
        assert left.value.code == 0, said.err
    found = json.loads((tmp_path / "found" / "diagnosis.json").read_text("utf-8"))
    assert "set_up" not in found
    lags = {cause["joint"] for cause in found["causes"] if cause["effect"] == "servo_lag"}
    assert lags == {1, 2}
    assert {one["trajectory"] for one in found["held_out"]["joints"]}
    before, after = (
        np.sqrt(np.mean([one[f"{key}_rms_rad"] ** 2 for one in found["held_out"]["joints"]]))
        for key in ("before", "after")
    )
    assert after < 0.4 * before
    assert "Readings come in steps of 0.0879°" in said.out
