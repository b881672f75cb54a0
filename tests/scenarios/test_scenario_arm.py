"""A scenario may run another arm than the paper's: its table says which."""

import numpy as np
import pytest

from armtwin.models.errors import InputError
from armtwin.models.kinematics import forward
from armtwin.scenarios.closed_loop import record_scenario
from armtwin.scenarios.runner.calibration import methods_for
from armtwin.scenarios.runner.world import build_world, declared_arm
from armtwin.scenarios.scenario import check_scenario, read_scenario


def scenario(n: int, **tables: object) -> dict[str, object]:
    path = {"kind": "circle", "radius_mm": 15.0, "samples": 6}
    return {
        "schema": "armtwin.scenario/1",
        "title": "Another arm",
        "arm": {"name": "mine", "link_lengths_mm": [220.0 / n] * n},
        "trajectories": {"circle": path, "line": path},
        **tables,
    }


@pytest.mark.parametrize("n", [2, 4, 6])
def test_the_tip_of_any_arm_runs_along_the_declared_paths_and_its_markers_are_seen(n: int):
    declared = check_scenario(scenario(n), "mine.toml")
    _, recording = record_scenario(declared)
    assert recording.arm.n_joints == n
    assert set(recording.markers_px) == set("abcdefg"[: n + 1])
    wanted = declared.trajectories["circle"].poses()[:, :2]
    np.testing.assert_allclose(forward(recording.arm, recording.q_cmd[:6])[:, :2], wanted, atol=2e-3)


def test_geometry_left_out_means_an_arm_as_drawn():
    declared = check_scenario(scenario(4), "mine.toml")
    np.testing.assert_array_equal(build_world(declared).deviation.lengths_mm, np.zeros(4))
    assert declared_arm(declared).name == "mine"


@pytest.mark.parametrize(
    ("key", "found", "wanted"), [("length_errors_mm", [1.0] * 4, 2), ("joint_errors_rad", [0.1] * 3, 2)]
)
def test_geometry_of_another_arm_is_refused_with_the_count_that_is_wanted(key: str, found: list[float], wanted: int):
    with pytest.raises(InputError, match=rf"geometry\.{key} needs {wanted} entries for arm 'mine', found {len(found)}"):
        check_scenario(scenario(2, geometry={key: found}), "mine.toml")


def test_a_path_beyond_the_arm_is_refused_with_its_name():
    far = {"kind": "circle", "radius_mm": 15.0, "centre_mm": [-400.0, 0.0]}
    with pytest.raises(InputError, match=r"mine\.toml: trajectories\.circle: pose 0 .* is out of reach"):
        check_scenario(scenario(2, trajectories={"circle": far, "line": far}), "mine.toml")


def test_algorithm_1_is_run_on_the_papers_arm_alone():
    assert set(methods_for(read_scenario("paper").drawn_arm)) == {"algorithm-1", "least-squares"}
    assert set(methods_for(read_scenario("two-joints").drawn_arm)) == {"least-squares"}
