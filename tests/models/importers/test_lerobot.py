"""LeRobot data sets, made by the library that reads them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from armtwin.models.errors import InputError
from armtwin.models.importers.lerobot import lattice_step, read_lerobot
from armtwin.models.importers.writing import write_import
from armtwin.models.recordings.moving_reader import read_moving

pyarrow = pytest.importorskip("pyarrow")
parquet = pytest.importorskip("pyarrow.parquet")

JOINTS = ["shoulder_pan.pos", "elbow_flex.pos", "gripper.pos"]
EPISODES, ROWS, FPS = 2, 40, 30
DEG = 30.0 * np.sin(np.arange(EPISODES * ROWS) / 9.0)


def table(state: NDArray[np.float64], action: NDArray[np.float64], rows: slice) -> Any:
    number = np.arange(len(state))
    return pyarrow.table(
        {
            "observation.state": list(state[rows].astype(np.float32)),
            "action": list(action[rows].astype(np.float32)),
            "timestamp": ((number % ROWS) / FPS).astype(np.float32)[rows],
            "frame_index": (number % ROWS)[rows],
            "episode_index": (number // ROWS)[rows],
            "index": number[rows],
            "task_index": np.zeros(len(number), dtype=int)[rows],
        }
    )


def write_set(folder: Path, version: str, scale: float = 1.0, offset: float = 0.0) -> Path:
    """A data set of three joints whose first two follow the same sine, a degree behind."""
    action = np.column_stack([offset + scale * DEG, offset - scale * DEG, np.full(len(DEG), 50.0)])
    state = action - scale * np.array([1.0, -1.0, 0.0])
    (folder / "meta").mkdir(parents=True)
    v3 = version == "v3.0"
    single = "data/chunk-{episode_chunk:03d}/episode_{episode_index:06d}.parquet"
    names: Any = JOINTS if v3 else {"motors": JOINTS}
    info = {
        "codebase_version": version,
        "fps": FPS,
        "data_path": "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet" if v3 else single,
        "features": {key: {"dtype": "float32", "names": names} for key in ("observation.state", "action")},
    }
    (folder / "meta" / "info.json").write_text(json.dumps(info))
    data = folder / "data" / "chunk-000"
    data.mkdir(parents=True)
    if v3:
        parquet.write_table(table(state, action, slice(None)), data / "file-000.parquet")
    else:
        for episode in range(EPISODES):
            rows = slice(episode * ROWS, (episode + 1) * ROWS)
            parquet.write_table(table(state, action, rows), data / f"episode_{episode:06d}.parquet")
    return folder


@pytest.mark.parametrize("version", ["v2.1", "v3.0"])
def test_both_versions_give_episodes_as_trajectories(tmp_path: Path, version: str) -> None:
    log = read_lerobot(write_set(tmp_path / "set", version), "deg")
    assert log.joints == ("shoulder_pan", "elbow_flex")
    assert (log.clock, log.motion) == ("synthetic", "moving")
    assert [str(name) for name in log.trajectory[[0, ROWS]]] == ["episode_000000", "episode_000001"]
    np.testing.assert_allclose(log.q_cmd[:, 0], np.radians(DEG), atol=1e-6)
    np.testing.assert_allclose(log.q_cmd[:, 0] - log.q_meas[:, 0], np.radians(1.0), atol=1e-6)
    np.testing.assert_allclose(np.diff(log.time_s[:ROWS]), 1 / FPS, atol=1e-6)
    assert any("gripper" in note for note in log.notes)
    assert any("no clock" in note for note in log.notes)


def test_a_set_of_episodes_is_a_moving_recording_that_can_be_read(tmp_path: Path) -> None:
    write_import(tmp_path / "rec", read_lerobot(write_set(tmp_path / "set", "v3.0"), "deg"))
    read = read_moving(tmp_path / "rec")
    assert read.motions == ("episode_000000", "episode_000001")
    assert read.clock == "synthetic"
    np.testing.assert_allclose(read.q_cmd[:, 0], np.radians(DEG), atol=1e-6)


def test_single_episodes_can_be_chosen(tmp_path: Path) -> None:
    log = read_lerobot(write_set(tmp_path / "set", "v2.1"), "deg", episodes=[1])
    assert set(log.trajectory.tolist()) == {"episode_000001"}


def test_raw_counts_need_the_calibration_file_and_are_read_by_it(tmp_path: Path) -> None:
    folder = write_set(tmp_path / "set", "v3.0", scale=4095.0 / 360.0, offset=2000.0)
    with pytest.raises(InputError, match="have no zero without the robot's calibration file"):
        read_lerobot(folder, "counts")
    ranges = {
        name: {"id": 1, "drive_mode": 0, "homing_offset": 0, "range_min": 1000, "range_max": 3000}
        for name in ("shoulder_pan", "elbow_flex")
    }
    ranges["elbow_flex"]["drive_mode"] = 1
    file = tmp_path / "arm.json"
    file.write_text(json.dumps(ranges))
    log = read_lerobot(folder, "counts", file)
    np.testing.assert_allclose(log.q_cmd[:, 0], np.radians(DEG), atol=1e-5)
    np.testing.assert_allclose(log.q_cmd[:, 1], np.radians(DEG), atol=1e-5)  # turned twice: by the data, by drive_mode


def test_a_normalised_range_is_told_by_the_file_or_by_the_steps_of_the_readings(tmp_path: Path) -> None:
    half_range_deg = 2000 * 360.0 / 4095.0 / 2.0
    folder = write_set(tmp_path / "set", "v3.0", scale=100.0 / half_range_deg)
    file = tmp_path / "arm.json"
    one = {"range_min": 1000, "range_max": 3000}
    file.write_text(json.dumps({"shoulder_pan": one, "elbow_flex": one}))
    log = read_lerobot(folder, "range", file)
    np.testing.assert_allclose(log.q_cmd[:, 0], np.radians(DEG), atol=1e-5)
    with pytest.raises(InputError, match="cannot be told from the readings"):
        read_lerobot(folder, "range")


def test_the_step_of_a_lattice_is_found_and_a_smooth_signal_has_none() -> None:
    rng = np.random.default_rng(0)
    counts = np.rint(400 * np.sin(np.arange(3000) / 50.0) + rng.normal(0, 2, 3000))
    step = lattice_step(0.1 * counts)
    assert step == pytest.approx(0.1, rel=1e-3)
    assert lattice_step(40 * np.sin(np.arange(3000) / 50.0)) is None


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('"v3.0"', '"v4.0"', "codebase_version: found 'v4.0'"),
        ("data/chunk", "../data/chunk", "parquet files inside the folder are wanted"),
        ("file-{file", "part-{file", "is it a whole data set"),
        ('"features"', '"feature"', "key 'features' is missing"),
        ("{", "[", "not JSON"),
    ],
)
def test_what_is_no_data_set_is_refused_by_name(tmp_path: Path, old: str, new: str, said: str) -> None:
    folder = write_set(tmp_path / "set", "v3.0")
    info = folder / "meta" / "info.json"
    info.write_text(info.read_text().replace(old, new))
    with pytest.raises(InputError, match=said):
        read_lerobot(folder, "deg")


def test_a_unit_is_never_guessed(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"say deg .* range .* or counts"):
        read_lerobot(write_set(tmp_path / "set", "v3.0"), None)


def test_a_broken_parquet_file_is_named(tmp_path: Path) -> None:
    folder = write_set(tmp_path / "set", "v3.0")
    (folder / "data" / "chunk-000" / "file-000.parquet").write_bytes(b"version https://git-lfs.github.com/spec/v1\n")
    with pytest.raises(InputError, match=r"file-000.parquet: cannot be read as LeRobot's"):
        read_lerobot(folder, "deg")
