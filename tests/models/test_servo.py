from pathlib import Path

import pytest

from armtwin.models.errors import InputError
from armtwin.models.servo import NOMINAL_SERVO, nominal_servo, read_servo


def test_nominal_servo_is_the_data_sheets() -> None:
    servo = nominal_servo()
    assert servo.name == "TowerPro MG996R"
    assert servo.stall_torque_nm == pytest.approx(9.4 * 0.0980665, abs=5e-4)  # 9.4 kgf cm
    assert servo.no_load_speed_rad_s == pytest.approx(1.0472 / 0.17, rel=1e-3)  # 60 degrees in 0.17 s


def test_dead_band_is_an_angle_of_half_a_degree() -> None:
    assert nominal_servo().dead_band_rad == pytest.approx(5.0 * 3.1416 / 2000.0)


def test_unknown_key_is_refused_with_the_nearest(tmp_path: Path) -> None:
    path = tmp_path / "servo.toml"
    path.write_text(NOMINAL_SERVO.read_text("utf-8").replace("friction_nm", "frictoin_nm"), "utf-8")
    with pytest.raises(InputError, match=r"servo.toml: unknown key 'frictoin_nm'; did you mean 'friction_nm'"):
        read_servo(path)
