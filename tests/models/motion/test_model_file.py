"""Models of other people's arms: what is drawn is left out, what would read other files is refused, in one line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from armtwin.models.errors import InputError
from armtwin.models.motion.loads import gravity_torques
from armtwin.models.motion.model_file import load_model
from armtwin.models.motion_arm import model_arm
from armtwin.models.recordings.moving import ModelArm

PUBLISHED = """<mujoco model="arm">
  <compiler meshdir="assets"/>
  <default><default class="visual"><geom type="mesh" material="plastic"/></default></default>
  <asset><material name="plastic"/><mesh name="link" file="link.stl"/>
  </asset>
  <worldbody>
    <geom name="floor" type="plane" size="1 1 0.1" material="plastic"/>
    <body name="upper">
      <joint name="shoulder" axis="0 1 0" range="-2 2" damping="0.6" frictionloss="0.05"/>
      <inertial pos="0.1 0 0" mass="0.2" diaginertia="1e-4 2e-4 2e-4"/>
      <geom name="skin" class="visual" mesh="link"/>
      <site name="tool" material="plastic"/>
    </body>
  </worldbody>
  <contact><exclude body1="world" body2="upper"/><pair geom1="skin" geom2="floor"/></contact>
  <actuator><position name="shoulder" joint="shoulder" kp="20"/></actuator>
  <keyframe><key qpos="0.5"/></keyframe>
</mujoco>"""


def write(folder: Path, text: str, name: str = "arm.xml") -> Path:
    path = folder / name
    path.write_text(text, "utf-8")
    return path


def test_an_arm_whose_meshes_are_elsewhere_is_weighed_and_moved(tmp_path: Path) -> None:
    path = write(tmp_path, PUBLISHED)
    torques = gravity_torques(ModelArm("arm", ("shoulder",), path), np.array([[0.0], [np.pi / 2]]))
    assert torques is not None
    np.testing.assert_allclose(np.abs(torques[:, 0]), [0.2 * 9.81 * 0.1, 0.0], atol=1e-9)
    spec = model_arm("arm", path, ("shoulder",)).build()
    assert spec.compile().nv == 1


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("nothing", r"no XML"),
        ("<sdf/>", r"begins with <sdf>; <mujoco> \(MJCF\) or <robot> \(URDF\) is wanted"),
        ('<mujoco><include file="../../secret.xml"/></mujoco>', "includes another file; save it as one file"),
        ('<mujoco><extension><plugin plugin="x"/></extension></mujoco>', "asks for a plugin"),
        ("<mujoco><worldbody><body><joint/></body></worldbody></mujoco>", "does not load .* its <inertial>"),
        ('<mujoco><equality><weld body1="a" body2="b"/></equality></mujoco>', "closes a loop of bodies"),
    ],
)
def test_what_is_no_model_of_an_arm_is_refused_alike_by_both_readers(tmp_path: Path, text: str, said: str) -> None:
    path = write(tmp_path, text)
    with pytest.raises(InputError, match=f"arm.xml: .*{said}|arm.xml: {said}"):
        load_model(path)
    with pytest.raises(InputError, match=f"arm.xml: .*{said}|arm.xml: {said}"):
        model_arm("arm", path, ("shoulder",))


def test_a_file_that_is_no_text_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "arm.xml"
    path.write_bytes(b"\xff\xfe\x00\x81")
    with pytest.raises(InputError, match=r"arm\.xml: no XML"):
        load_model(path)
