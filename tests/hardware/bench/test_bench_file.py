import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tomli_w

from armtwin.hardware.bench.bench_file import BenchSetup, read_bench
from armtwin.models.camera import Camera
from armtwin.models.camera_files import nominal_camera, write_camera
from armtwin.models.errors import InputError

Write = Callable[[dict[str, Any]], Path]


def refusal(path: Path) -> str:
    with pytest.raises(InputError) as caught:
        read_bench(path)
    message = str(caught.value)
    assert "\n" not in message
    return message


def test_reads_joints_camera_and_defaults(setup: BenchSetup):
    assert setup.port == "/dev/ttyACM0"
    assert setup.arm.name == "planar3"
    assert setup.camera.image_width == 1280
    np.testing.assert_allclose(setup.servo_map.us_per_rad, [636.62, -636.62, 600.0])
    np.testing.assert_allclose(setup.limits.min_rad, [-1.2, -1.2, -1.4])
    np.testing.assert_allclose(setup.rest_rad, 0.0)


def test_unknown_key_is_named_with_the_nearest(bench_table: dict[str, Any], write_bench: Write):
    bench_table["joints"][1]["zero_uz"] = 1500.0

    message = refusal(write_bench(bench_table))

    assert "bench.toml" in message
    assert "joint 2: unknown key 'zero_uz'; did you mean 'zero_us'?" in message


def test_limit_outside_the_servos_range_is_refused(bench_table: dict[str, Any], write_bench: Write):
    bench_table["joints"][0]["max_rad"] = 1.7

    message = refusal(write_bench(bench_table))

    assert "joint 1: max_rad 1.7 lies outside the servo's range, -1.5708 to 1.5708 rad" in message


def test_narrower_servo_narrows_what_limits_are_taken(bench_table: dict[str, Any], write_bench: Write):
    bench_table["joints"][0] |= {"min_us": 1000.0, "max_us": 2000.0}

    assert "min_rad -1.2 lies outside" in refusal(write_bench(bench_table))


def test_pulses_beyond_the_firmwares_are_refused(bench_table: dict[str, Any], write_bench: Write):
    bench_table["joints"][0]["max_us"] = 2600.0

    assert "joint 1: max_us: " in refusal(write_bench(bench_table))


def test_two_joints_on_one_servo_are_refused(bench_table: dict[str, Any], write_bench: Write):
    bench_table["joints"][0]["servo"] = 2

    assert "found servos [2, 2, 3]" in refusal(write_bench(bench_table))


@pytest.mark.parametrize("n_joints", [1, 2, 6])
def test_an_arm_of_one_to_six_joints_has_a_servo_for_each(
    bench_table: dict[str, Any], write_bench: Write, tmp_path: Path, n_joints: int
):
    arm = {"schema": "armtwin.arm/1", "name": "mine", "link_lengths_mm": [50.0] * n_joints}
    (tmp_path / "arm.toml").write_text(tomli_w.dumps(arm))
    joint = {"min_rad": -1.0, "max_rad": 1.0}
    bench_table |= {"arm": "arm.toml", "joints": [{"servo": i + 1, **joint} for i in range(n_joints)]}

    assert read_bench(write_bench(bench_table)).servo_map.pulses_us(np.zeros(n_joints)).tolist() == [1500.0] * n_joints


def test_joints_that_are_not_the_arms_are_refused_with_both_counts(bench_table: dict[str, Any], write_bench: Write):
    bench_table["joints"].pop()

    message = refusal(write_bench(bench_table))

    assert "arm: the paper's arm, since no arm is named, has 3 joints, 2 tables [[joints]] are there" in message


def test_limits_beyond_the_arms_own_are_refused(bench_table: dict[str, Any], write_bench: Write, tmp_path: Path):
    arm = {"schema": "armtwin.arm/1", "name": "mine", "link_lengths_mm": [50.0], "joint_limits_rad": [[-1.0, 0.5]]}
    (tmp_path / "arm.toml").write_text(tomli_w.dumps(arm))
    bench_table |= {"arm": "arm.toml", "joints": [{"servo": 1, "min_rad": -1.0, "max_rad": 1.0}]}

    assert "joint 1: min_rad -1 to max_rad 1 goes beyond the arm file's joint_limits_rad" in refusal(
        write_bench(bench_table)
    )


def test_rest_pose_outside_the_limits_is_refused(bench_table: dict[str, Any], write_bench: Write):
    bench_table["motion"] = {"rest_rad": [0.0, 1.3, 0.0]}

    assert "rest_rad of joint 2 is 1.3, outside its limits" in refusal(write_bench(bench_table))


@pytest.mark.parametrize("key", ["start_speed_rad_s", "speed_rad_s"])
def test_a_speed_that_takes_a_step_longer_than_the_board_may_is_refused(
    bench_table: dict[str, Any], write_bench: Write, key: str
):
    bench_table["motion"] = {"max_step_rad": 0.6, key: 0.0099}

    message = refusal(write_bench(bench_table))

    assert f"motion.{key} is 0.0099, at least 0.01 is wanted: a step of 0.6 rad would take 61 s" in message
    bench_table["motion"][key] = 0.01
    assert read_bench(write_bench(bench_table)).motion.max_step_rad == 0.6


def test_no_step_is_longer_than_a_joints_range(bench_table: dict[str, Any], write_bench: Write):
    """A largest step beyond every range means no bound; the widest range here is 2.6 rad."""
    bench_table["motion"] = {"max_step_rad": 100.0, "start_speed_rad_s": 2.6 / 60}

    assert read_bench(write_bench(bench_table)).motion.max_step_rad == 100.0


def test_a_number_that_is_none_is_refused(bench_table: dict[str, Any], write_bench: Write):
    bench_table["joints"][0]["max_rad"] = float("nan")

    assert "joint 1: max_rad: " in refusal(write_bench(bench_table))


def test_camera_file_outside_the_folder_is_refused(bench_table: dict[str, Any], write_bench: Write):
    bench_table["camera"]["calibration"] = "../camera.yaml"

    assert "camera.calibration: '../camera.yaml' leaves the bench file's folder" in refusal(write_bench(bench_table))


def test_a_video_is_looked_for_beside_the_bench_file(bench_table: dict[str, Any], write_bench: Write, tmp_path: Path):
    bench_table["camera"]["source"] = "film.avi"
    (tmp_path / "film.avi").write_bytes(b"")

    assert read_bench(write_bench(bench_table)).camera_settings.source == str(tmp_path / "film.avi")


ALLOWED = "a device like /dev/video0, an MJPEG stream (http:// or https://) or a video file beside the bench file"


def test_a_missing_video_is_named_with_what_else_a_source_may_be(bench_table: dict[str, Any], write_bench: Write):
    bench_table["camera"]["source"] = "film.avi"

    message = refusal(write_bench(bench_table))

    assert "camera.source: no file 'film.avi' beside the bench file; " in message
    assert ALLOWED in message


def test_a_stream_of_another_protocol_is_refused(bench_table: dict[str, Any], write_bench: Write):
    bench_table["camera"]["source"] = "rtsp://x/y"

    assert f"camera.source: found 'rtsp://x/y'; {ALLOWED} is wanted" in refusal(write_bench(bench_table))


def test_a_plane_of_the_arm_behind_the_camera_is_refused(bench_table: dict[str, Any], write_bench: Write):
    bench_table["camera"]["arm_plane_z_mm"] = -5000.0

    message = refusal(write_bench(bench_table))

    assert "bench.toml: camera.arm_plane_z_mm: found -5000, which the camera does not look at" in message


@pytest.mark.parametrize(("key", "least"), [("onset_s", 1.5), ("still_s", 2.0)])
def test_a_time_too_short_to_come_to_rest_in_is_refused(
    bench_table: dict[str, Any], write_bench: Write, key: str, least: float
):
    bench_table["settle"] = {"onset_s": 0.1, key: least, "timeout_s": least}

    assert f"settle: timeout_s is {least:g}, more than {key} {least:g} is wanted" in refusal(write_bench(bench_table))
    bench_table["settle"]["timeout_s"] = least + 0.1
    assert read_bench(write_bench(bench_table)).settle.timeout_s == least + 0.1


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("zero_us", "1500", "zero_us: a number is wanted, found '1500'"),
        ("min_rad", True, "min_rad: a number is wanted, found True"),
        ("servo", "1", "servo: a whole number is wanted, found '1'"),
        ("direction", True, "direction: 1 or -1 is wanted, found True"),
    ],
)
def test_a_value_of_another_type_is_refused(
    bench_table: dict[str, Any], write_bench: Write, key: str, value: object, message: str
):
    bench_table["joints"][0][key] = value

    assert f"bench.toml: joint 1: {message}" in refusal(write_bench(bench_table))


def test_a_byte_order_mark_is_no_fault(bench_table: dict[str, Any], write_bench: Write):
    """Windows' Notepad writes one."""
    path = write_bench(bench_table)
    path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes())

    assert read_bench(path).port == "/dev/ttyACM0"


def test_missing_camera_file_is_named(bench_table: dict[str, Any], write_bench: Write):
    bench_table["camera"]["calibration"] = "webcam.yaml"

    assert "no file 'webcam.yaml'" in refusal(write_bench(bench_table))


def test_camera_without_the_boards_pose_is_refused(bench_table: dict[str, Any], tmp_path: Path):
    known = nominal_camera()
    write_camera(tmp_path / "camera.yaml", Camera(1280, 720, known.K, known.lens, np.eye(3), np.zeros(3)))
    (tmp_path / "bench.toml").write_bytes(tomli_w.dumps(bench_table).encode())

    assert "no pose of the board" in refusal(tmp_path / "bench.toml")


@pytest.mark.parametrize("content", [b"schema = ", b"\xff\xfe", b"joints = 3"])
def test_what_is_no_bench_file_is_refused_in_one_line(tmp_path: Path, content: bytes):
    (tmp_path / "bench.toml").write_bytes(content)

    assert "bench.toml" in refusal(tmp_path / "bench.toml")


def test_missing_bench_file_is_named(tmp_path: Path):
    assert "none.toml" in refusal(tmp_path / "none.toml")


GUIDE = Path(__file__).parents[3] / "hardware" / "guide"


def test_the_guides_bench_file_is_a_good_one(tmp_path: Path):
    write_camera(tmp_path / "camera.yaml", nominal_camera())
    (tmp_path / "bench.toml").write_bytes((GUIDE / "bench.toml").read_bytes())

    assert read_bench(tmp_path / "bench.toml").camera_settings.focus == 30


def test_every_picture_of_the_guide_is_there():
    text = (GUIDE.parent / "bench-guide.md").read_text("utf-8")
    pictures = re.findall(r"!\[.*?\]\((.*?)\)", text)

    assert len(pictures) >= 4
    for picture in pictures:
        assert (GUIDE.parent / picture).is_file(), picture


@pytest.mark.parametrize("text", ["x = " + "9" * 5000, "x = " + "[" * 100_000], ids=["endless-number", "too-deep"])
def test_what_toml_readers_choke_on_is_refused(tmp_path: Path, text: str):
    (tmp_path / "bench.toml").write_text(text)

    assert "bench.toml: not TOML" in refusal(tmp_path / "bench.toml")


def test_a_path_with_a_zero_byte_is_refused(bench_table: dict[str, Any], write_bench: Write):
    path = write_bench(bench_table)
    bench_table["camera"]["calibration"] = "a\0b"
    path.write_bytes(tomli_w.dumps(bench_table).encode())

    assert "camera.calibration: 'a\\x00b' is no name of a file" in refusal(path)
