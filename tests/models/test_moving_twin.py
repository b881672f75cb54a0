from pathlib import Path

import pytest

from armtwin.models.errors import InputError
from armtwin.models.moving_twin import is_moving_twin, read_moving_twin
from tests.sim.motion.worlds import TWO_AXES

TWIN = """schema = "armtwin.twin/1"
motion = "moving"
[arm]
name = "two"
model = "two.xml"
joints = ["yaw", "pitch"]
[geometry]
joint_errors_rad = [0.01, 0.02]
[[effects]]
effect = "friction"
joint = 2
parameters = { coulomb_rad = 0.012 }
"""


def written(folder: Path, text: str) -> Path:
    (folder / "two.xml").write_text(TWO_AXES)
    (folder / "twin.toml").write_text(text)
    return folder / "twin.toml"


def test_a_moving_twin_is_read_with_its_arm_its_zeros_and_its_causes(tmp_path: Path) -> None:
    path = written(tmp_path, TWIN)
    assert is_moving_twin(path)
    twin = read_moving_twin(path)
    assert twin.arm.joints == ("yaw", "pitch")
    assert twin.zeros_rad.tolist() == [0.01, 0.02]
    assert [(name, site.joint) for name, site, _ in twin.causes] == [("friction", 2)]


@pytest.mark.parametrize(
    ("there", "instead", "message"),
    [
        ("coulomb_rad", "coulomb", "unknown key 'coulomb'"),
        ("joint = 2", "joint = 3", "joint: found 3"),
        ('"two.xml"', '"../two.xml"', "leaves the twin's folder"),
        ('"two.xml"', '"three.xml"', "no such file"),
        ("[0.01, 0.02]", "[0.01]", "2 are wanted, one a joint"),
    ],
)
def test_what_it_cannot_be_is_refused_by_its_key(tmp_path: Path, there: str, instead: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        read_moving_twin(written(tmp_path, TWIN.replace(there, instead)))
