"""A twin as a URDF file, read back by a URDF library and by MuJoCo."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ET
from pathlib import Path

import mujoco
import numpy as np
import pytest
import yourdfpy
from numpy.typing import NDArray

from armtwin.models.arm import Arm, nominal_arm
from armtwin.models.errors import InputError
from armtwin.models.export.onto_urdf import export_onto_urdf
from armtwin.models.export.urdf import export_urdf
from armtwin.models.kinematics import Deviation, forward
from armtwin.models.twin import Twin, TwinEffect, rebuild
from armtwin.sim.physics.simulation import simulate

DEVIATION = Deviation(np.array([1.5, -2.0, 0.4, 0.1]), np.array([0.02, -0.03, 0.01]))
POSES = np.array([[0.0, 0.0, 0.0], [0.3, -0.2, 0.5], [-0.7, 0.4, 0.1]])
JOINTS = ("joint1", "joint2", "joint3")


def twin(*effects: TwinEffect, deviation: Deviation = DEVIATION) -> Twin:
    return Twin(nominal_arm(), deviation, np.zeros(3), None, effects)


def by_library(path: Path, frame: str = "marker_f", joints: tuple[str, ...] = JOINTS) -> NDArray[np.float64]:
    """(N, 3) places of a frame, mm, at `POSES`."""
    robot = yourdfpy.URDF.load(str(path), load_meshes=False, build_scene_graph=True)
    places = []
    for q in POSES:
        robot.update_cfg(dict(zip(joints, q, strict=True)))
        places.append(1e3 * robot.get_transform(frame, robot.base_link)[:3, 3])
    return np.array(places)


def by_mujoco(path: Path, frame: str = "marker_f") -> NDArray[np.float64]:
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    places = []
    for q in POSES:
        data.qpos[:] = q
        mujoco.mj_kinematics(model, data)
        places.append(1e3 * data.body(frame).xpos)
    return np.array(places)


@pytest.mark.parametrize("read", [by_library, by_mujoco])
def test_a_reader_puts_the_tip_where_the_calibrated_arm_has_it(tmp_path: Path, read: object) -> None:
    export_urdf(twin(), tmp_path / "arm.urdf")
    wanted = forward(nominal_arm(), POSES, DEVIATION)[:, :2]
    places = read(tmp_path / "arm.urdf")  # type: ignore[operator]
    np.testing.assert_allclose(places[:, :2], wanted, atol=1e-6)


@pytest.mark.parametrize(
    "effect",
    [
        TwinEffect("axis_tilt", 2, None, {"tilt_x_rad": 0.05, "tilt_y_rad": -0.03}),
        TwinEffect("joint_slip", 2, None, {"jump_rad": 0.05, "from_sample": 0}),
        TwinEffect("marker_offset", None, "f", {"x_mm": 1.0, "y_mm": -2.0}),
    ],
    ids=lambda effect: effect.effect,
)
def test_what_is_rigid_stands_in_the_links(tmp_path: Path, effect: TwinEffect) -> None:
    held = export_urdf(twin(effect), tmp_path / "arm.urdf")
    assert held.held == (effect,)
    wanted = simulate(rebuild(twin(effect)), POSES)[:, -1]
    np.testing.assert_allclose(by_library(tmp_path / "arm.urdf"), wanted, atol=0.01)


def test_joint_zeros_stand_in_the_origins_and_never_in_calibration(tmp_path: Path) -> None:
    export_urdf(twin(), tmp_path / "arm.urdf")
    root = ET.parse(tmp_path / "arm.urdf").getroot()
    yaw = float(root.find("joint[@name='joint2']/origin").get("rpy").split()[2])  # type: ignore[union-attr]
    assert yaw == pytest.approx(np.pi / 2 - 0.03)
    assert root.find(".//calibration") is None


def test_limits_and_friction_are_those_of_the_servo(tmp_path: Path) -> None:
    export_urdf(twin(), tmp_path / "arm.urdf")
    robot = yourdfpy.URDF.load(str(tmp_path / "arm.urdf"), load_meshes=False)
    joint = robot.joint_map["joint1"]
    assert (joint.limit.upper, joint.limit.effort, joint.limit.velocity) == pytest.approx((1.5708, 0.922, 6.16))
    assert float(joint.dynamics.friction) == pytest.approx(0.01)


def test_what_urdf_cannot_hold_is_said_beside_it(tmp_path: Path) -> None:
    play = TwinEffect("backlash", 2, None, {"width_rad": 0.02})
    gain = TwinEffect("servo_gain", 1, None, {"gain": 1.05})
    export_urdf(twin(play, gain), tmp_path / "arm.urdf")
    note = json.loads((tmp_path / "arm.armtwin.json").read_text())
    assert {one["effect"] for one in note["not_held"]} == {"backlash", "servo_gain"}
    assert any("dynamics" in line for line in note["readers_drop"])
    assert "does not hold backlash (joint 2)" in (tmp_path / "arm.urdf").read_text()


@pytest.fixture
def own(tmp_path: Path) -> Path:
    """A person's own URDF of the drawn arm, with names and a comment of their own."""
    path = tmp_path / "own.urdf"
    export_urdf(twin(deviation=Deviation.none(nominal_arm())), path)
    text = path.read_text().replace("joint1", "shoulder").replace("joint2", "elbow").replace("joint3", "wrist")
    path.write_text(
        text.replace(
            '<link name="base" />',
            '<!-- mine --><link name="base"><visual><origin/>'
            '<geometry><mesh filename="package://mine/base.stl"/></geometry></visual></link>',
        )
    )
    return path


def test_a_persons_own_urdf_is_mended_and_keeps_what_is_theirs(tmp_path: Path, own: Path) -> None:
    export_onto_urdf(twin(), own, tmp_path / "mended.urdf", tip="marker_f")
    wanted = forward(nominal_arm(), POSES, DEVIATION)[:, :2]
    names = ("shoulder", "elbow", "wrist")
    end = by_library(tmp_path / "mended.urdf", "end2", names)
    stated = Arm("plain", nominal_arm().link_lengths_mm[:2], np.zeros(2))
    elbow = forward(stated, POSES[:, :2] + np.pi / 2, Deviation(DEVIATION.lengths_mm[:2], DEVIATION.joints_rad[:2]))
    np.testing.assert_allclose(end[:, :2], elbow[:, :2], atol=1e-6)
    np.testing.assert_allclose(by_library(tmp_path / "mended.urdf", joints=names)[:, :2], wanted, atol=1e-6)
    text = (tmp_path / "mended.urdf").read_text()
    assert "<!-- mine -->" in text
    assert "package://mine/base.stl" in text


def test_a_link_whose_end_cannot_be_told_is_left_and_named(tmp_path: Path, own: Path) -> None:
    """The last link carries two markers, E and F: either may be the tip."""
    export_onto_urdf(twin(), own, tmp_path / "mended.urdf")
    (note,) = json.loads((tmp_path / "mended.armtwin.json").read_text())["notes"]
    assert note.startswith("link 3 ends in no frame of the file that can be told")
    assert note.endswith("name the tip")


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('type="revolute"', 'type="prismatic"', "0 joints turn .* the twin has 3; name them with --joints"),
        ("<robot", "<robots", "not XML"),
        ("0.12 0 0", "0.5 0 0", "lies 500.0 mm from the axis before, the twin's drawing has 120.0 mm"),
        ("0.12 0 0", "0.12 x 0", "three numbers are wanted"),
        ("<robot", "<!DOCTYPE robot []><robot", "defines entities"),
    ],
)
def test_a_urdf_that_cannot_be_mended_is_refused_in_one_line(
    tmp_path: Path, own: Path, old: str, new: str, said: str
) -> None:
    assert old in own.read_text()
    own.write_text(own.read_text().replace(old, new))
    with pytest.raises(InputError, match=said):
        export_onto_urdf(twin(), own, tmp_path / "mended.urdf")
    assert not (tmp_path / "mended.urdf").exists()


def test_a_file_in_an_encoding_that_nobody_knows_is_answered_in_a_short_line(tmp_path: Path, own: Path) -> None:
    own.write_text(f'<?xml version="1.0" encoding="utf{"1" * 5000}"?><robot/>')
    with pytest.raises(InputError, match="not XML") as caught:
        export_onto_urdf(twin(), own, tmp_path / "mended.urdf")
    assert len(str(caught.value)) < 300


def test_names_and_limits_of_the_drawing_stand_in_the_file(tmp_path: Path) -> None:
    limits = np.array([[-1.0, 1.5], [0.0, 2.0]])
    arm = Arm("mine", np.array([100.0, 80.0]), np.zeros(2), joints=("shoulder", "elbow"), joint_limits_rad=limits)
    export_urdf(Twin(arm, Deviation.none(arm), np.zeros(3), None, ()), tmp_path / "mine.urdf")
    joints = ET.parse(tmp_path / "mine.urdf").getroot().findall("joint[@type='revolute']")
    found = {joint.get("name"): [float(joint.find("limit").get(key)) for key in ("lower", "upper")] for joint in joints}  # type: ignore[union-attr,arg-type]
    assert found == {"shoulder": [-1.0, 1.5], "elbow": [0.0, 2.0]}
