import json
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

from armtwin.models.catalogue.motion_injection import MotionCause
from armtwin.models.catalogue.site import Site
from armtwin.models.motion_arm import MotionArm
from armtwin.sim.motion.export import export_moving_mjcf
from armtwin.sim.motion.twin import simulate_twin_motion
from tests.sim.motion.worlds import Array, Motion, steps, swing, two_axes, upright

J2 = Site(joint=2)
IN_A_FILE: list[tuple[str, dict[str, Any]]] = [
    ("servo_lag", {"time_constant_s": 0.07}),
    ("speed_limit", {"speed_rad_s": 1.0}),
    ("friction", {"coulomb_rad": 0.012}),
    ("backlash", {"width_rad": 0.02}),
    ("hysteresis", {"lag_rad": 0.01, "length_rad": 0.05}),
    ("contact", {"stop_rad": 0.2, "side": 1}),
]


def stepped(path: Path, motion: Motion) -> Array:
    """(N, n) what the encoders of a file read when plain MuJoCo steps it, 10 steps a row."""
    note = json.loads(path.with_name(f"{path.stem}.armtwin.json").read_text())
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    places = [[int(model.joint(name).qposadr[0]) for name in joint["encoder"]] for joint in note["joints"]]
    readings = np.empty_like(motion.q_cmd)
    for place, angle in zip(places, motion.q_cmd[0], strict=True):
        data.qpos[place[0]] = angle
    data.ctrl[:] = motion.q_cmd[0]
    mujoco.mj_step(model, data, 500)  # bristles and stops come to rest
    for row, command in enumerate(motion.q_cmd):
        readings[row] = [data.qpos[place].sum() for place in places]
        data.ctrl[:] = command
        mujoco.mj_step(model, data, 10)
    return readings


@pytest.mark.parametrize(("name", "parameters"), IN_A_FILE)
@pytest.mark.parametrize("motion", [swing(3), steps(3)], ids=["swing", "steps"])
def test_plain_mujoco_moves_the_file_as_the_twin_moves(
    tmp_path: Path, name: str, parameters: dict[str, Any], motion: Motion
) -> None:
    causes: list[MotionCause] = [(name, J2, parameters)]
    held = export_moving_mjcf(causes, upright(), tmp_path / "twin.xml")
    assert [cause[0] for cause in held.held] == [name]
    expected = simulate_twin_motion(causes, upright(), [motion])
    assert np.abs(stepped(tmp_path / "twin.xml", motion) - expected).max() < 1e-3


def test_a_heavy_rotor_is_in_the_file_for_what_stays_below_the_top_speed(tmp_path: Path) -> None:
    causes: list[MotionCause] = [("inertia", J2, {"armature_kg_m2": 0.05})]
    export_moving_mjcf(causes, upright(), tmp_path / "twin.xml")
    for motion in (swing(3), steps(3, (0.0, 0.06, 0.0))):
        expected = simulate_twin_motion(causes, upright(), [motion])
        assert np.abs(stepped(tmp_path / "twin.xml", motion) - expected).max() < 1e-3


def test_an_arm_of_any_axes_is_written_too(tmp_path: Path) -> None:
    arm: MotionArm = two_axes(tmp_path)
    export_moving_mjcf([("friction", J2, {"coulomb_rad": 0.02})], arm, tmp_path / "twin.xml")
    motion = swing(2)
    expected = simulate_twin_motion([("friction", J2, {"coulomb_rad": 0.02})], arm, [motion])
    assert np.abs(stepped(tmp_path / "twin.xml", motion) - expected).max() < 1e-3


def test_what_no_file_holds_stands_beside_it_with_what_makes_it(tmp_path: Path) -> None:
    causes: list[MotionCause] = [
        ("latency", J2, {"delay_s": 0.05}),
        ("gravity_sag", J2, {"compliance_rad_per_nm": 0.05}),
        ("friction", J2, {"coulomb_rad": 0.01, "stribeck_rad": 0.01, "stribeck_speed_rad_s": 0.1}),
    ]
    held = export_moving_mjcf(causes, upright(), tmp_path / "twin.xml")
    assert held.held == ()
    note = json.loads((tmp_path / "twin.armtwin.json").read_text())
    recipes = {one["effect"]: one["recipe"] for one in note["not_held"]}
    assert "delay_s ago" in recipes["latency"]
    assert "qfrc_gravcomp" in recipes["gravity_sag"]
    assert "stribeck_rad" in recipes["friction"]
    assert "delay_s" in (tmp_path / "twin.xml").read_text()
