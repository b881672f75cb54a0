"""The simulated bench of a scenario. Board and gauge are held before its camera too, which no other bench can do."""

from __future__ import annotations

from armtwin.scenarios.runner.picture import generator, sensor_of
from armtwin.scenarios.runner.world import build_motion_world, build_world
from armtwin.scenarios.scenario import ObstacleTable, ScenarioFile
from armtwin.sim.bench import SimulatedBench
from armtwin.sim.render import Part
from armtwin.sim.render.solids import box


def simulated_bench(
    scenario: ScenarioFile, purpose: str, n_poses: int | None = None, samples_before: int = 0
) -> SimulatedBench:
    """Return the scenario's bench, not yet connected; each purpose has sensor noise of its own.

    `n_poses` are to come; `samples_before` were run earlier, so that what happens at some sample has happened then.
    """
    return SimulatedBench(
        build_world(scenario, samples_before),
        seed=generator(scenario, purpose),
        sensor=sensor_of(scenario),
        shadows=scenario.picture.shadows,
        moving=build_motion_world(scenario),
        n_poses=n_poses,
        actuation={"scenario": scenario.fingerprint, "samples_before": samples_before},
        obstacles=[_obstacle(scenario, number, table) for number, table in enumerate(scenario.obstacles)],
    )


def _obstacle(scenario: ScenarioFile, number: int, table: ObstacleTable) -> Part:
    """Stand a board of the declared size before the arm's plane; robot x is -x of the board frame (equation 12)."""
    (x, y), (width, height) = table.centre_mm, table.size_mm
    left, low = scenario.bench.base_in_board_mm[0] - x, scenario.bench.base_in_board_mm[1] + y
    front = scenario.bench.arm_plane_z_mm - table.before_arm_mm
    solid = box(
        (left - width / 2, low - height / 2, front - table.thickness_mm), (left + width / 2, low + height / 2, front)
    )
    return Part(f"obstacle {number}", solid, table.colour)
