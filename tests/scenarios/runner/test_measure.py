"""Measuring a run's frames: what the scenario says of detection itself acts too."""

from __future__ import annotations

from typing import Any

import numpy as np

from armtwin.models.arm import nominal_arm
from armtwin.models.camera_files import nominal_camera
from armtwin.models.recordings.recording import Recording, make_samples
from armtwin.scenarios.runner.measure import with_faults
from armtwin.scenarios.scenario import ScenarioFile, check_scenario

N = 150


def scenario(**effect: Any) -> ScenarioFile:
    """Return a scenario of three trajectories, of 50 poses each, with one effect."""
    circle = {"kind": "circle", "radius_mm": 15.0}
    return check_scenario(
        {
            "schema": "armtwin.scenario/1",
            "title": "faults of detection",
            "trajectories": {"one": circle, "two": circle, "line": circle},
            "effects": [effect],
        },
        "s.toml",
    )


def measured(n: int) -> Recording:
    return Recording(
        arm=nominal_arm(),
        camera=nominal_camera(),
        arm_plane_z_mm=-80.87,
        sample=make_samples(n),
        time_s=np.full(n, np.nan),
        trajectory=np.full(n, "path"),
        q_cmd=np.zeros((n, 3)),
        markers_px={name: np.full((n, 2), 100.0 * k) for k, name in enumerate("abcf")},
    )


def test_markers_are_swapped_in_the_poses_that_the_scenario_names() -> None:
    swapped = scenario(name="marker_swap", marker="b", other="c", samples=[7, 160])
    before = with_faults(swapped, "before", measured(N)).markers_px["b"][:, 0]
    assert np.flatnonzero(before == 200.0).tolist() == [7]
    after = with_faults(swapped, "after", measured(50)).markers_px["b"][:, 0]
    assert np.flatnonzero(after == 200.0).tolist() == [10]


def test_gross_errors_are_the_same_in_every_run_of_a_scenario() -> None:
    wrong = scenario(name="outliers", rate=0.1, size_px=40.0)
    first, again = (with_faults(wrong, "before", measured(N)).markers_px["f"] for _ in range(2))
    np.testing.assert_array_equal(first, again)
    assert 0 < (first != 300.0).any(axis=1).sum() < N // 2
