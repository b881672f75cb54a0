"""A twin as an MJCF file: plain MuJoCo loads it, and it comes to stand where the twin does."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray

from armtwin.models.arm import Arm, nominal_arm
from armtwin.models.export.mjcf import export_mjcf
from armtwin.models.kinematics import Deviation
from armtwin.models.twin import Twin, TwinEffect, rebuild
from armtwin.sim.physics.simulation import simulate

DEVIATION = Deviation(np.array([1.5, -2.0, 0.4, 0.1]), np.array([0.02, -0.03, 0.01]))
UPRIGHT = replace(nominal_arm(), gravity_m_s2=np.array([0.0, -9.81]))
# Back and forth, so that play and friction show which side they came from.
PATH = np.array([[0.0, 0.0, 0.0], [0.3, -0.2, 0.2], [0.5, -0.4, 0.1], [0.3, -0.2, 0.2], [-0.1, 0.1, -0.3]])


def moved(path: Path, q_cmd: NDArray[np.float64], seconds: float = 3.0) -> NDArray[np.float64]:
    """(N, 3) tip, mm, of a model file under plain MuJoCo, each command held until the arm rests."""
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    tips = []
    for q in [np.zeros(model.nu), *q_cmd]:
        data.ctrl[:] = q
        mujoco.mj_step(model, data, round(seconds / model.opt.timestep))
        mujoco.mj_kinematics(model, data)
        tips.append(1000.0 * data.site("marker_f").xpos)
    return np.array(tips[1:])


@pytest.mark.parametrize(
    ("arm", "effect"),
    [
        (nominal_arm(), None),
        (UPRIGHT, None),
        (nominal_arm(), TwinEffect("backlash", 2, None, {"width_rad": 0.02})),
        (nominal_arm(), TwinEffect("hysteresis", 1, None, {"lag_rad": 0.01, "length_rad": 0.05})),
        (
            UPRIGHT,
            TwinEffect("gravity_sag", None, None, {"compliance1_rad_per_nm": 0.1, "compliance2_rad_per_nm": 0.2}),
        ),
        (UPRIGHT, TwinEffect("link_bending", 1, None, {"flexibility_per_nm2": 1.0})),
        (UPRIGHT, TwinEffect("payload", None, None, {"mass_kg": 0.05, "from_sample": 2})),
        (nominal_arm(), TwinEffect("axis_tilt", 2, None, {"tilt_x_rad": 0.05, "tilt_y_rad": -0.03})),
        (nominal_arm(), TwinEffect("servo_gain", 1, None, {"gain": 1.05})),
        (nominal_arm(), TwinEffect("marker_offset", None, "f", {"x_mm": 1.0, "y_mm": -2.0})),
        (nominal_arm(), TwinEffect("joint_slip", 2, None, {"jump_rad": 0.03, "from_sample": 0})),
    ],
    ids=lambda value: value.effect if isinstance(value, TwinEffect) else None,
)
def test_plain_mujoco_brings_the_arm_where_the_twin_goes(tmp_path: Path, arm: Arm, effect: TwinEffect | None) -> None:
    twin = Twin(arm, DEVIATION, np.zeros(3), None, () if effect is None else (effect,))
    held = export_mjcf(twin, tmp_path / "arm.xml")
    world = rebuild(twin)
    if world.events:  # the file is the arm after the recording
        world = replace(world, events=tuple(replace(event, sample=0) for event in world.events))
    wanted = simulate(world, PATH)[:, -1]
    assert not held.not_held
    # The bench trims a droop that friction gives the horn, and its bristles remember that: 0.4 mrad here.
    tolerance_mm = 0.1 if effect is not None and effect.effect == "hysteresis" else 0.05
    np.testing.assert_allclose(moved(tmp_path / "arm.xml", PATH), wanted, atol=tolerance_mm)


def test_the_effect_is_seen_in_the_file(tmp_path: Path) -> None:
    """The comparison above could not fail if no effect moved the tip by more than its tolerance."""
    plain, loose = (tmp_path / name for name in ("plain.xml", "loose.xml"))
    export_mjcf(Twin(nominal_arm(), DEVIATION, np.zeros(3), None, ()), plain)
    effect = TwinEffect("backlash", 2, None, {"width_rad": 0.02})
    export_mjcf(Twin(nominal_arm(), DEVIATION, np.zeros(3), None, (effect,)), loose)
    apart = np.linalg.norm(moved(plain, PATH) - moved(loose, PATH), axis=1)
    assert apart[3] > 1.0


def test_what_the_file_cannot_hold_stands_in_its_comment_and_beside_it(tmp_path: Path) -> None:
    effects = (
        TwinEffect("quantization", None, None, {"step_rad": 0.02}),
        TwinEffect("camera_tilt", None, None, {"tilt_x_rad": 0.01}),
        TwinEffect("backlash", 3, None, {"width_rad": 0.01}),
    )
    export_mjcf(Twin(nominal_arm(), DEVIATION, np.zeros(3), None, effects), tmp_path / "arm.xml")
    note = json.loads((tmp_path / "arm.armtwin.json").read_text())
    assert [one["effect"] for one in note["not_held"]] == ["quantization", "camera_tilt"]
    assert note["not_held"][0]["parameters"] == {"step_rad": 0.02}
    assert [one["effect"] for one in note["held"]] == ["backlash"]
    text = (tmp_path / "arm.xml").read_text()
    assert "does not hold quantization, which acts on the commands" in text
    assert "camera_tilt, which belongs to the camera" in text
