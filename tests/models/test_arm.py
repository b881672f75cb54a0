from pathlib import Path

import numpy as np
import pytest

from armtwin.models.arm import Arm, arm_from_table, nominal_arm, read_arm
from armtwin.models.errors import InputError
from armtwin.models.recordings.writer import arm_table
from armtwin.models.validation import ArmTable, check

GOOD = """\
schema = "armtwin.arm/1"
name = "planar3"
link_lengths_mm = [120.0, 121.7, 38.0, 6.73]
gravity_m_s2 = [0.0, -9.81]
"""


def file_of(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "arm.toml"
    path.write_text(text)
    return path


def test_the_nominal_arm_has_table_1s_lengths():
    np.testing.assert_array_equal(nominal_arm().link_lengths_mm, [120.00, 121.70, 38.00, 6.73])


def test_planar3_has_three_joints_and_the_papers_markers():
    arm = nominal_arm()
    assert arm.n_joints == 3
    assert arm.marker_names == ("a", "b", "c", "f")
    assert arm.known_markers == ("a", "b", "c", "e", "f")
    np.testing.assert_allclose(arm.zero_pose_rad, np.pi / 2)


@pytest.mark.parametrize("n", [1, 2, 6])
def test_a_plain_chain_has_a_joint_a_link_and_a_marker_more(n):
    arm = Arm("plain", np.full(n, 50.0), np.zeros(2))
    assert arm.n_joints == n
    assert arm.marker_names == arm.known_markers == tuple("abcdefg"[: n + 1])
    np.testing.assert_array_equal(arm.zero_pose_rad, 0.0)


def test_an_arm_file_is_read(tmp_path):
    arm = read_arm(file_of(tmp_path, GOOD + "tip_mass_kg = 0.02\n"))
    assert arm.has_tip_offset
    assert arm.tip_mass_kg == 0.02
    assert arm.link_masses_kg is None
    np.testing.assert_array_equal(arm.gravity_m_s2, [0.0, -9.81])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("[120.0, 121.7, 38.0, 6.73]", "[0.12, 0.1217, 0.038, 0.00673]"), "these look like metres: multiply by 1000"),
        (("[120.0, 121.7, 38.0, 6.73]", "[120.0, 121.7, 38.0]"), "needs 4 entries"),
        (("[120.0, 121.7, 38.0, 6.73]", "[-120.0, 121.7, 38.0, 6.73]"), "at least 0 is wanted, found -120.0"),
        (("[120.0, 121.7, 38.0, 6.73]", "[nan, 121.7, 38.0, 6.73]"), "arm.toml: link_lengths_mm entry 1: "),
        (("armtwin.arm/1", "armtwin.arm/9"), "arm.toml: schema"),
        (("gravity_m_s2", "gravity_ms2"), "unknown key 'gravity_ms2'; did you mean 'gravity_m_s2'"),
        (('name = "planar3"\n', ""), "key 'name' is missing"),
    ],
    ids=["metres", "too few lengths", "negative", "nan", "schema", "unknown key", "missing key"],
)
def test_a_bad_arm_file_is_refused_in_one_line(tmp_path, change, message):
    with pytest.raises(InputError, match=message) as error:
        read_arm(file_of(tmp_path, GOOD.replace(*change)))
    assert "\n" not in str(error.value)
    assert error.value.exit_code == 2


def test_a_file_that_is_no_toml_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"arm\.toml"):
        read_arm(file_of(tmp_path, "link_lengths_mm = [120.0,"))


def test_an_arm_file_that_does_not_exist_is_refused(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        read_arm(tmp_path / "none.toml")


NAMED = """
schema = "armtwin.arm/1"
name = "mine"
link_lengths_mm = [100.0, 80.0]
joints = ["shoulder", "elbow"]
joint_limits_rad = [[-1.0, 1.5], [0.0, 2.0]]
"""


def test_the_joints_of_an_arm_have_names_and_limits_that_a_recording_keeps(tmp_path):
    path = tmp_path / "arm.toml"
    path.write_text(NAMED)
    arm = read_arm(path)
    assert arm.joint_labels == ("joint 1 (shoulder)", "joint 2 (elbow)")
    again = arm_from_table(check(ArmTable, arm_table(arm), "recording.json"))
    assert again.joints == arm.joints
    np.testing.assert_array_equal(again.joint_limits_rad, [[-1.0, 1.5], [0.0, 2.0]])


def test_joints_without_names_are_counted():
    assert nominal_arm().joint_labels == ("joint 1", "joint 2", "joint 3")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('["shoulder", "elbow"]', '["shoulder"]', "joints needs 2 entries, one a joint, found 1"),
        ('["shoulder", "elbow"]', '["elbow", "elbow"]', "two of them are called 'elbow'"),
        ("[0.0, 2.0]]", "[2.0, 0.0]]", "joint_limits_rad of joint 2: found 2 to 0, lowest first is wanted"),
    ],
)
def test_names_and_limits_that_do_not_fit_the_joints_are_refused(tmp_path, old, new, message):
    path = tmp_path / "arm.toml"
    path.write_text(NAMED.replace(old, new))
    with pytest.raises(InputError, match=message):
        read_arm(path)
