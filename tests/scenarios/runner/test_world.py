"""The world that a scenario declares."""

from dataclasses import replace

import numpy as np

from armtwin.models.kinematics import inverse, marker_positions
from armtwin.models.world import Moment
from armtwin.scenarios.runner.world import build_world, declared_arm, true_deviation
from armtwin.scenarios.scenario import read_scenario
from armtwin.sim.physics.simulation import simulate


def test_the_injected_geometry_is_what_the_simulated_arm_does() -> None:
    scenario = read_scenario("geometric")
    arm = declared_arm(scenario)
    q = inverse(arm, scenario.trajectories["line"].poses()[::10])
    points = simulate(build_world(scenario), q)
    wanted = marker_positions(arm, q, true_deviation(scenario))
    columns = [build_world(scenario).arm.known_markers.index(name) for name in arm.marker_names]
    assert np.abs(points[:, columns, :2] - wanted).max() < 0.005


def test_what_happened_at_a_sample_has_happened_in_a_later_recording() -> None:
    bumped = read_scenario("bumped-camera")
    camera = build_world(bumped).true_camera
    first, later = build_world(bumped), build_world(bumped, samples_before=150)
    start = Moment(0, 0.0, 0.0)
    assert np.array_equal(first.camera_at(start).t_board_camera_mm, camera.t_board_camera_mm)
    assert not np.array_equal(later.camera_at(start).t_board_camera_mm, camera.t_board_camera_mm)


def test_the_paper_scenario_makes_the_papers_error_on_the_line() -> None:
    """4.0 mm before calibration; 2.0 mm of it from the geometry alone."""
    scenario = read_scenario("paper")
    arm = declared_arm(scenario)
    q = np.concatenate([inverse(arm, path.poses()) for path in scenario.trajectories.values()])
    path = scenario.trajectories["line"].poses()
    world = build_world(scenario)
    f = world.arm.known_markers.index("f")

    def mean_error(points: np.ndarray) -> float:
        return float(np.linalg.norm(points[-len(path) :, f, :2] - path[:, :2], axis=1).mean())

    assert abs(mean_error(simulate(world, q)) - 4.0) < 0.1
    geometric = replace(world, mechanics=(), electronics=(), relieved=())
    assert abs(mean_error(simulate(geometric, q)) - 2.03) < 0.02
