"""From a recording of a faulty arm to commands that take it along a path that nobody recorded."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from armtwin.calib.diagnosis.diagnosis import diagnose
from armtwin.models.arm import nominal_arm
from armtwin.models.camera_files import nominal_camera
from armtwin.models.catalogue.registry import Site, effect_named
from armtwin.models.kinematics import Deviation, inverse
from armtwin.models.plan import paper_plan
from armtwin.models.trajectories import line
from armtwin.models.wanted_path import WantedPath
from armtwin.models.world import ideal_world
from armtwin.scenarios.diagnosis.findings import twin_of
from armtwin.scenarios.twins.correction import correct
from armtwin.sim.observe import make_recording
from armtwin.sim.physics.simulation import default_clock, simulate

DEVIATION = Deviation(np.array([1.5, -2.0, 0.4, 0.0]), np.array([0.02, -0.03, 0.01]))


def test_the_diagnosed_twin_takes_the_real_arm_along_an_unseen_path_better_than_its_geometry_alone() -> None:
    bench = ideal_world(nominal_arm(), nominal_camera(), -80.87, np.array([40.0, -33.0]), DEVIATION)
    bench = effect_named("backlash").inject(bench, {"width_rad": 0.02}, Site(joint=2))
    plan = paper_plan(bench.arm)
    recording = make_recording(
        bench, plan.q_cmd, plan.trajectory, default_clock(len(plan)), np.random.default_rng(1), 0.06, held_out=("line",)
    )
    twin = twin_of(diagnose(recording))
    assert [effect.effect for effect in twin.effects] == ["backlash"]

    there = line((-175.0, 10.0), (-125.0, 60.0), 10, 2.5)
    path = np.concatenate([there, there[::-1]])
    wanted = WantedPath(np.full(20, "unseen"), np.zeros(20), ("",) * 20, tip_mm=path[:, :2], theta_rad=path[:, 2])
    extended = correct(twin, wanted)
    geometry = correct(replace(twin, effects=()), wanted)
    commands = {
        "drawn": inverse(bench.arm, path),
        "geometry": geometry.plan.q_cmd,
        "extended": extended.plan.q_cmd,
    }
    error_mm = {
        name: float(np.linalg.norm(simulate(bench, q)[:, -1, :2] - path[:, :2], axis=1).mean())
        for name, q in commands.items()
    }
    assert error_mm["extended"] < 0.15
    assert error_mm["extended"] < 0.25 * error_mm["geometry"] < 0.25 * error_mm["drawn"]
    # What it promised is what came.
    assert abs(float(extended.before_mm.mean()) - error_mm["drawn"]) < 0.15
