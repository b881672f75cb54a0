"""`armtwin run` for arms of two and of four joints, through the command line, from pictures to the report."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
import tomli_w

ARMS = {
    2: ([110.0, 95.0], [1.5, -2.0], [0.02, -0.03]),
    4: ([60.0, 55.0, 50.0, 45.0], [1.5, -2.0, 1.0, -1.0], [0.02, -0.03, 0.02, -0.02]),
}


def scenario(n_joints: int) -> dict[str, object]:
    lengths, length_errors, joint_errors = ARMS[n_joints]
    return {
        "schema": "armtwin.scenario/1",
        "title": "Another arm",
        "seed": 5,
        "board_views": 5,
        "gauge_lengths_mm": [30.0],
        "gauge_placements": 2,
        "arm": {"name": "mine", "link_lengths_mm": lengths},
        "geometry": {"length_errors_mm": length_errors, "joint_errors_rad": joint_errors},
        "trajectories": {
            "circle": {"kind": "circle", "radius_mm": 25.0, "samples": 10},
            "line": {"kind": "line", "start_mm": [-145.0, 25.0], "end_mm": [-115.0, 45.0], "samples": 4},
        },
    }


@pytest.mark.parametrize("n_joints", [2, pytest.param(4, marks=pytest.mark.slow)])
def test_the_whole_run_finds_what_the_arm_was_built_off_its_drawing(n_joints: int, tmp_path: Path) -> None:
    path, out = tmp_path / "mine.toml", tmp_path / "out"
    path.write_text(tomli_w.dumps(scenario(n_joints)))
    command = [sys.executable, "-m", "armtwin", "run", str(path), "--out", str(out)]
    finished = subprocess.run(command, capture_output=True, text=True, timeout=600, check=False)
    assert finished.returncode == 0, finished.stderr[-2000:]

    results = json.loads((out / "results.json").read_text())
    truth = [*ARMS[n_joints][1], *ARMS[n_joints][2]]
    found = {row["parameter"]: row["least-squares"][0]["value"] for row in results["tables"]["4"]["rows"]}
    assert len(found) == 2 * n_joints
    for (name, value), true in zip(found.items(), truth, strict=True):
        assert value == pytest.approx(true, abs=0.05 if name.endswith("_mm") else 1e-3), name
    assert results["validation"]["mean_after_mm"] < 0.02 < 1.0 < results["validation"]["mean_before_mm"]
    assert json.loads((out / "diagnosis" / "diagnosis.json").read_text())["verdict"] == "none"
    assert (out / "report.html").stat().st_size > 10_000
