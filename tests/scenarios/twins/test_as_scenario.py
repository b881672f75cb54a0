"""A twin's file wherever an arm or a scenario is asked for."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from armtwin.models.arm import Arm, nominal_arm, read_arm
from armtwin.models.camera_files import nominal_camera
from armtwin.models.errors import InputError
from armtwin.models.kinematics import Deviation
from armtwin.models.twin import Twin, TwinEffect, rebuild, write_twin
from armtwin.scenarios.benches.spec import SimulatedSpec, bench_spec
from armtwin.scenarios.runner.world import build_world
from armtwin.scenarios.scenario import read_scenario
from armtwin.sim.physics.simulation import simulate

TURN = np.array([[np.cos(0.1), -np.sin(0.1), 0.0], [np.sin(0.1), np.cos(0.1), 0.0], [0.0, 0.0, 1.0]])
TWIN = Twin(
    replace(nominal_arm(), gravity_m_s2=np.array([0.0, -9.81])),
    Deviation(np.array([1.5, -2.0, 0.4, 0.1]), np.array([0.02, -0.03, 0.01])),
    np.array([40.3, -33.2, -80.0]),
    nominal_camera().moved(TURN, np.array([3.0, -4.0, 5.0])),
    (TwinEffect("backlash", 2, None, {"width_rad": 0.02}),),
)


def test_the_scenarios_bench_is_the_twin(tmp_path: Path) -> None:
    write_twin(tmp_path / "twin.toml", TWIN)
    world, twin = build_world(read_scenario(str(tmp_path / "twin.toml"))), rebuild(TWIN)
    np.testing.assert_allclose(world.true_camera.R_board_camera, twin.true_camera.R_board_camera, atol=1e-12)
    np.testing.assert_allclose(world.true_camera.t_board_camera_mm, twin.true_camera.t_board_camera_mm, atol=1e-9)
    np.testing.assert_allclose(world.base_in_board_mm, twin.base_in_board_mm)
    q = np.array([[0.2, -0.1, 0.3], [0.0, 0.1, 0.1]])
    np.testing.assert_allclose(simulate(world, q), simulate(twin, q), atol=1e-9)
    assert isinstance(bench_spec(str(tmp_path / "twin.toml")), SimulatedSpec)


def test_what_a_scenario_cannot_say_is_refused_with_what_to_do(tmp_path: Path) -> None:
    camera = nominal_camera()
    write_twin(tmp_path / "twin.toml", replace(TWIN, camera=replace(camera, K=camera.K * [[1.1], [1.1], [1.0]])))
    with pytest.raises(InputError, match="this twin has a camera of its own; use armtwin simulate"):
        read_scenario(str(tmp_path / "twin.toml"))


def test_the_arm_of_a_twins_file_is_its_drawing(tmp_path: Path) -> None:
    write_twin(tmp_path / "twin.toml", TWIN)
    np.testing.assert_array_equal(read_arm(tmp_path / "twin.toml").link_lengths_mm, nominal_arm().link_lengths_mm)


def test_the_twin_of_another_arm_is_refused_with_its_name_and_the_way_to_run_it(tmp_path: Path) -> None:
    arm = Arm("plotter", np.array([110.0, 95.0]), np.zeros(2))
    write_twin(tmp_path / "twin.toml", Twin(arm, Deviation.none(arm), np.zeros(3), None, ()))
    with pytest.raises(InputError, match=r"the twin of another arm, 'plotter' of 2 joints: .* with armtwin simulate"):
        read_scenario(str(tmp_path / "twin.toml"))
