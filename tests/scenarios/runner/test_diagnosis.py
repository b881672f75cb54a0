"""The extended twin's commands, on the simulated bench's physics."""

import numpy as np
import pytest

from armtwin.calib.diagnosis.diagnosis import Diagnosis, diagnose
from armtwin.models.camera import project
from armtwin.models.kinematics import inverse
from armtwin.models.trajectories import line
from armtwin.models.world import Moment, World
from armtwin.scenarios.closed_loop import record_scenario
from armtwin.scenarios.runner.diagnosis import camera_now, corrected_line
from armtwin.scenarios.scenario import ScenarioFile, check_scenario
from armtwin.sim.physics.simulation import default_clock, simulate

GEOMETRY = {"length_errors_mm": [6.7, 4.6, -0.7, 1.0], "joint_errors_rad": [0.02, 0.018, 0.083]}
PLAY = {"name": "backlash", "joint": 2, "width_rad": 0.03}


def scenario_with(*effects: dict[str, object]) -> ScenarioFile:
    """Return two short circles and a line."""
    table = {
        "schema": "armtwin.scenario/1",
        "title": "Short",
        "geometry": GEOMETRY,
        "trajectories": {
            "circle_15": {"kind": "circle", "radius_mm": 15, "samples": 24},
            "circle_25": {"kind": "circle", "radius_mm": 25, "samples": 24},
            "line": {"kind": "line", "start_mm": [-145, 25], "end_mm": [-115, 45], "samples": 6},
        },
        "effects": list(effects),
    }
    return check_scenario(table, "short.toml")


def there_and_back() -> np.ndarray:
    """(16, 3) poses on a line and back again: every place is approached from either side."""
    path = line((-145.0, 25.0), (-115.0, 45.0), 8)
    return np.concatenate([path, path[::-1]])


def missed_mm(world: World, diagnosis: Diagnosis, q_cmd: np.ndarray, poses: np.ndarray) -> np.ndarray:
    """(N,) true distance of the tip from the poses when `q_cmd` follows on what was diagnosed."""
    everything = np.concatenate([diagnosis.problem.context.q_cmd, q_cmd])
    points = simulate(world, everything, default_clock(len(everything)))[-len(poses) :]
    tip = points[:, world.arm.known_markers.index("f"), :2]
    return np.asarray(np.linalg.norm(tip - poses[:, :2], axis=1))


@pytest.fixture(scope="module")
def played() -> tuple[World, Diagnosis]:
    world, recording = record_scenario(scenario_with(PLAY))
    return world, diagnose(recording)


def test_play_is_corrected_from_whichever_side_a_pose_is_approached(played: tuple[World, Diagnosis]) -> None:
    world, diagnosis = played
    poses = there_and_back()
    geometric = inverse(world.arm, poses, delta=diagnosis.geometry.deviation)
    assert missed_mm(world, diagnosis, geometric, poses).mean() > 1.0
    assert missed_mm(world, diagnosis, corrected_line(diagnosis, poses).q_cmd, poses).max() < 0.25


def test_where_nothing_is_wrong_the_commands_are_those_of_the_geometry() -> None:
    _, recording = record_scenario(scenario_with())
    diagnosis = diagnose(recording)
    assert diagnosis.verdict == "none"
    poses = there_and_back()
    wanted = inverse(recording.arm, poses, delta=diagnosis.geometry.deviation)
    assert np.allclose(corrected_line(diagnosis, poses).q_cmd, wanted, atol=1e-12)


def test_a_bumped_camera_is_known_where_it_stands_now() -> None:
    bump = {"rotation_x_rad": 0.004, "rotation_y_rad": -0.005, "translation_z_mm": 2.0, "from_sample": 30}
    world, recording = record_scenario(scenario_with({"name": "camera_moved", **bump}))
    now = camera_now(diagnose(recording))
    late = world.camera_at(Moment(len(recording) - 1, 0.0, 1.0))
    points = np.array([[0.0, 0.0, -80.87], [120.0, 40.0, -80.87], [140.0, 80.0, -80.87]])
    assert np.abs(project(world.true_camera, points) - project(late, points)).max() > 5.0
    assert np.abs(project(now, points) - project(late, points)).max() < 0.5
