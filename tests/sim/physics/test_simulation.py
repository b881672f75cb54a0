import numpy as np
import pytest

from armtwin.models.arm import Arm
from armtwin.models.camera_files import nominal_camera
from armtwin.models.kinematics import Deviation, marker_positions
from armtwin.models.world import Event, World, ideal_world
from armtwin.sim.physics.simulation import ArmSimulation, simulate
from tests.support.worlds import PLANE_MM, errors_rad, flat_world, scattered, upright_world, with_effect

# Far below any camera's noise: 0.03 px at the tip is 75e-6 rad.
NOTHING_RAD = 1e-5


@pytest.mark.parametrize("world", [flat_world(), upright_world()], ids=["flat", "upright"])
def test_without_effects_the_arm_stands_as_commanded(world: World) -> None:
    assert np.abs(errors_rad(world, scattered(25))).max() < NOTHING_RAD


def test_small_steps_either_way_arrive_too() -> None:
    q = np.cumsum(np.random.default_rng(4).normal(0.0, 0.003, (30, 3)), axis=0)
    assert np.abs(errors_rad(upright_world(), q)).max() < NOTHING_RAD


def test_the_true_geometry_is_what_moves() -> None:
    deviation = Deviation(np.array([5.0, -4.0, 2.0, 1.0]), np.array([0.05, -0.1, 0.08]))
    world = upright_world(deviation)
    q = scattered(5)
    expected = marker_positions(world.arm, q, deviation)
    seen = simulate(world, q)[:, [world.arm.known_markers.index(name) for name in "abcf"], :2]
    np.testing.assert_allclose(seen, expected, atol=0.005)


@pytest.mark.parametrize("n", [1, 2, 4, 6])
def test_chains_of_any_length_arrive(n: int) -> None:
    arm = Arm("chain", np.full(n, 90.0), np.array([0.0, -9.81]))
    world = ideal_world(arm, nominal_camera(), PLANE_MM)
    q = np.random.default_rng(n).uniform(-0.8, 0.8, (6, n))
    assert np.abs(errors_rad(world, q)).max() < 2 * NOTHING_RAD


def test_a_known_payload_does_not_move_a_stiff_arm() -> None:
    q = scattered(4)
    loaded = simulate(upright_world(), q, payload_kg=np.full(4, 0.1))
    np.testing.assert_allclose(loaded, simulate(upright_world(), q), atol=0.005)


def test_a_known_payload_bends_a_soft_arm_while_it_hangs() -> None:
    world = with_effect(upright_world(), "gravity_sag", {"compliance1_rad_per_nm": 0.1})
    q = np.tile([0.1, 0.0, 0.0], (3, 1))
    tip = simulate(world, q, payload_kg=np.array([0.0, 0.1, 0.0]))[:, -1]
    assert np.linalg.norm(tip[1] - tip[0]) > 1.0
    np.testing.assert_allclose(tip[2], tip[0], atol=0.005)


def test_an_event_happens_before_its_pose_is_reached() -> None:
    seen: list[float] = []
    world = flat_world().with_event(Event(2, lambda model, data: seen.append(float(data.qpos[0]))))
    arm = ArmSimulation(world)
    for sample, angle in enumerate((0.1, 0.2, 0.3)):
        arm.move(np.array([angle, 0.0, 0.0]), sample)
        assert len(seen) == (1 if sample >= 2 else 0)
    assert seen[0] == pytest.approx(0.2, abs=NOTHING_RAD)


def test_two_runs_of_a_world_are_the_same_to_the_bit() -> None:
    world = with_effect(upright_world(), "hysteresis", {"lag_rad": 0.01, "length_rad": 0.05}, joint=2)
    q = scattered(8)
    np.testing.assert_array_equal(simulate(world, q), simulate(world, q))


def test_bodies_are_named_and_in_mm() -> None:
    arm = ArmSimulation(flat_world())
    arm.move(np.zeros(3))
    bodies = arm.bodies()
    assert list(bodies) == ["link1", "end1", "link2", "end2", "link3", "end3"]
    np.testing.assert_allclose(bodies["link2"][:3, 3], [0.0, 120.0, 0.0], atol=0.005)
