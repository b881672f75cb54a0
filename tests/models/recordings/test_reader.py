"""Every way in which a recording can break its contract, and the one line that it is answered with."""

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from armtwin.models.camera import project
from armtwin.models.errors import RecordingError
from armtwin.models.recordings.reader import read_recording
from armtwin.models.recordings.writer import write_recording


@pytest.fixture
def folder(recording, tmp_path) -> Path:
    target = tmp_path / "recording"
    write_recording(target, recording)
    return target


def change_header(folder: Path, change: Callable[[dict[str, Any]], object]) -> None:
    path = folder / "recording.json"
    header = json.loads(path.read_text())
    change(header)
    path.write_text(json.dumps(header))


def change_cell(folder: Path, line: int, column: str, text: str) -> None:
    """Set a cell by its line in the file (the header is line 1)."""
    path = folder / "samples.csv"
    lines = [row.split(",") for row in path.read_text().splitlines()]
    lines[line - 1][lines[0].index(column)] = text
    path.write_text("\n".join(",".join(row) for row in lines) + "\n")


def rename_column(folder: Path, old: str, new: str) -> None:
    path = folder / "samples.csv"
    head, rest = path.read_text().split("\n", 1)
    path.write_text(",".join(new if name == old else name for name in head.split(",")) + "\n" + rest)


def drop_column(folder: Path, column: str) -> None:
    path = folder / "samples.csv"
    lines = [row.split(",") for row in path.read_text().splitlines()]
    index = lines[0].index(column)
    path.write_text("\n".join(",".join(row[:index] + row[index + 1 :]) for row in lines) + "\n")


def refused(folder: Path, message: str) -> None:
    """Reading raises the exit-code-2 error whose one line holds `message`."""
    with pytest.raises(RecordingError, match=re.escape(message)) as error:
        read_recording(folder)
    assert "\n" not in str(error.value)
    assert error.value.exit_code == 2


def test_a_whole_recording_is_read(folder):
    read = read_recording(folder)
    assert len(read) == 6
    assert np.isnan(read.markers_px["f"][2]).all()
    assert read.held_out == ("line",)


def test_blank_lines_at_the_end_and_a_byte_order_mark_are_no_fault(folder):
    path = folder / "samples.csv"
    path.write_text("\ufeff" + path.read_text() + "\n\n", encoding="utf-8")
    assert len(read_recording(folder)) == 6


def test_a_rounded_rotation_is_made_orthonormal(folder):
    printed = [[-0.9988, 0.0041, 0.0497], [-0.0047, -0.9999, -0.0127], [0.0496, -0.0129, 0.9987]]
    change_header(folder, lambda header: header["camera"].update(board_to_camera_rotation=printed))
    R = read_recording(folder).camera.R_board_camera
    np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(R, printed, atol=1e-3)


@pytest.mark.parametrize("name", ["recording.json", "samples.csv"])
def test_a_missing_file_is_named(folder, name):
    (folder / name).unlink()
    refused(folder, f"{name}: no such file; a recording folder needs it")


@pytest.mark.parametrize("name", ["recording.json", "samples.csv"])
def test_a_folder_in_place_of_a_file_is_named(folder, name):
    (folder / name).unlink()
    (folder / name).mkdir()
    refused(folder, f"{name}: no plain file; a recording folder needs it")


def test_a_whole_number_of_thousands_of_digits_is_refused(folder):
    (folder / "recording.json").write_text('{"arm_plane_z_mm": ' + "9" * 5000 + "}")
    refused(folder, "recording.json: not JSON (Exceeds the limit")


@pytest.mark.parametrize("length", [1e300, 1e10, 10_001.0])
def test_a_length_that_no_arm_has_is_refused(folder, length):
    change_header(folder, lambda header: header["arm"]["link_lengths_mm"].__setitem__(0, length))
    refused(folder, "recording.json: arm.link_lengths_mm entry 1: at most 10000 is wanted, found")


@pytest.mark.parametrize(
    ("model", "coefficients", "kind"),
    [
        ("plumb_bob", [0.1, 0.2, 0.0, 0.0, 0.3, 0.0, 0.0, 0.0], "plumb_bob"),
        ("rational_polynomial", [0.1, 0.2, 0.0, 0.0, 0.3, *[0.0] * 9], "plumb_bob"),
        ("rational_polynomial", [0.1, 0.2, 0.0, 0.0, 0.3, 0.1, 0.2, 0.3], "rational_polynomial"),
        ("equidistant", [0.03, 0.01, -0.01, 0.001], "equidistant"),
        ("thin_prism", [0.1] * 12, "thin_prism"),
        ("", [], "plumb_bob"),
        ("none", [], "plumb_bob"),
    ],
)
def test_a_lens_is_read_by_the_name_that_ros_has_for_it(folder, model, coefficients, kind):
    keys = {"distortion_model": model, "distortion_coefficients": coefficients}
    change_header(folder, lambda header: header["camera"].update(keys))
    lens = read_recording(folder).camera.lens
    assert lens.model == kind
    kept = len(lens.coefficients)
    np.testing.assert_array_equal(lens.coefficients, [*coefficients, *[0.0] * kept][:kept])


def test_zeros_behind_the_coefficients_change_no_pixel(folder):
    points = np.random.default_rng(0).uniform(-50.0, 50.0, (20, 3))
    five = read_recording(folder).camera
    table = json.loads((folder / "recording.json").read_text())["camera"]
    longer = [*table["distortion_coefficients"], *[0.0] * 9]
    keys = {"distortion_model": "rational_polynomial", "distortion_coefficients": longer}
    change_header(folder, lambda header: header["camera"].update(keys))
    np.testing.assert_array_equal(project(read_recording(folder).camera, points), project(five, points))


@pytest.mark.parametrize(
    ("model", "coefficients"), [("omni", [0.1] * 5), ("equidistant", [0.1] * 8), ("plumb_bob", [0.1] * 6)]
)
def test_a_lens_that_is_not_held_is_refused_by_name(folder, model, coefficients):
    keys = {"distortion_model": model, "distortion_coefficients": coefficients}
    change_header(folder, lambda header: header["camera"].update(keys))
    refused(folder, f"'{model}'")


def test_a_missing_folder_is_named(tmp_path):
    refused(tmp_path / "nowhere", "nowhere: no such folder; a recording is a folder with recording.json")


def test_a_file_in_place_of_the_folder_is_refused(folder):
    refused(folder / "samples.csv", "samples.csv: no such folder")


@pytest.mark.parametrize(
    "column", ["sample", "time_s", "trajectory", "theta1_cmd_rad", "theta3_cmd_rad", "a_u_px", "f_v_px"]
)
def test_a_missing_column_is_named(folder, column):
    drop_column(folder, column)
    refused(folder, f"samples.csv: column '{column}' is missing")


@pytest.mark.parametrize(
    ("old", "new", "hint"),
    [
        ("a_u_px", "A_u_px", "did you mean 'a_u_px'?"),
        ("time_s", "colour", "valid names are"),
        ("f_u_px", "theta4_cmd_rad", "did you mean"),
    ],
)
def test_an_extra_column_is_named_with_the_nearest_valid_one(folder, old, new, hint):
    rename_column(folder, old, new)
    refused(folder, f"samples.csv: unknown column '{new}'")
    refused(folder, hint)


def test_a_column_whose_name_has_no_end_is_cut_in_the_message(folder):
    rename_column(folder, "time_s", "k" * 5000)
    with pytest.raises(RecordingError) as error:
        read_recording(folder)
    assert "unknown column 'kkk" in str(error.value)
    assert len(str(error.value)) < 1500  # the valid names are listed


def test_a_column_that_stands_twice_is_refused(folder):
    rename_column(folder, "f_u_px", "a_u_px")
    refused(folder, "samples.csv: column 'a_u_px' stands twice; keep one")


def test_measured_angles_come_for_every_joint(folder):
    rename_column(folder, "a_u_px", "theta1_meas_rad")
    drop_column(folder, "a_v_px")
    refused(folder, "samples.csv: column 'theta2_meas_rad' is missing")


@pytest.mark.parametrize("text", ["nan", "NaN", "inf", "-inf", "1e999"])
def test_a_command_that_is_not_finite_is_refused(folder, text):
    change_cell(folder, 4, "theta2_cmd_rad", text)
    refused(folder, f"samples.csv: line 4, column 'theta2_cmd_rad': '{text}' is not finite; a number is wanted")


def test_a_marker_written_as_nan_is_to_be_left_empty(folder):
    change_cell(folder, 3, "a_u_px", "nan")
    refused(folder, "samples.csv: line 3, column 'a_u_px': 'nan' is not finite; leave the cell empty")


def test_an_empty_command_is_refused(folder):
    change_cell(folder, 5, "theta1_cmd_rad", "")
    refused(folder, "samples.csv: line 5, column 'theta1_cmd_rad': empty, a number is wanted")


def test_text_in_place_of_a_number_is_shown(folder):
    change_cell(folder, 2, "a_v_px", "left")
    refused(folder, "samples.csv: line 2, column 'a_v_px': 'left' is no number")


@pytest.mark.parametrize("degrees", ["45.0", "-90"])
def test_an_angle_in_degrees_is_recognised(folder, degrees):
    change_cell(folder, 7, "theta3_cmd_rad", degrees)
    refused(folder, "samples.csv: line 7, column 'theta3_cmd_rad'")
    refused(folder, "is beyond 2 pi; angles are in radians, these look like degrees: name the column")


def test_lengths_in_metres_are_recognised(folder):
    change_header(folder, lambda header: header["arm"].update(link_lengths_mm=[0.12, 0.1217, 0.038, 0.00673]))
    refused(folder, "recording.json: arm: link_lengths_mm has a longest link of 0.1217 mm; lengths are in mm")


def test_a_camera_position_in_metres_is_recognised(folder):
    change_header(folder, lambda header: header["camera"].update(board_to_camera_translation_mm=[0.12, 0.04, 0.57]))
    refused(folder, "board_to_camera_translation_mm is in mm; this looks like metres")


def test_a_duplicated_sample_is_named_with_its_first_line(folder):
    change_cell(folder, 6, "sample", "1")
    refused(folder, "samples.csv: line 6, column 'sample': sample 1 stands already in line 3; number every pose once")


@pytest.mark.parametrize("text", ["-1", "1.5", "", "one", "9" * 30])
def test_a_sample_is_a_whole_number_from_0(folder, text):
    change_cell(folder, 3, "sample", text)
    refused(folder, "samples.csv: line 3, column 'sample'")


def test_time_that_runs_backwards_is_refused(folder):
    change_cell(folder, 7, "time_s", "2.0")
    refused(folder, "samples.csv: line 7, column 'time_s': time runs backwards, 2 s after 2.5 s")


def add_command_times(folder: Path, times: list[str]) -> None:
    path = folder / "samples.csv"
    lines = path.read_text().splitlines()
    cells = ["commanded_s", *times]
    path.write_text("\n".join(f"{line},{cell}" for line, cell in zip(lines, cells, strict=True)) + "\n")


def test_times_of_commands_are_read_where_they_stand(folder):
    for line, seen in enumerate(["0.4", "0.8", "1.2", "1.6", "2.0", "2.4"], start=2):
        change_cell(folder, line, "time_s", seen)
    add_command_times(folder, ["0.0", "0.5", "", "1.3", "1.7", "2.4"])
    np.testing.assert_array_equal(read_recording(folder).commanded_s, [0.0, 0.5, np.nan, 1.3, 1.7, 2.4])


@pytest.mark.parametrize(
    ("times", "message"),
    [
        (
            ["9.0", "", "", "", "", ""],
            "line 2, column 'commanded_s': 9 s is after time_s, 0.5 s, when the row was seen",
        ),
        (["", "0.1", "0.05", "", "", ""], "line 4, column 'commanded_s': time runs backwards, 0.05 s after 0.1 s"),
        (["", "soon", "", "", "", ""], "line 3, column 'commanded_s': 'soon' is no number"),
    ],
)
def test_a_command_is_given_before_it_is_seen_and_in_order(folder, times, message):
    for line in range(2, 8):
        change_cell(folder, line, "time_s", str(0.5 * (line - 1)))
    add_command_times(folder, times)
    refused(folder, message)


def test_a_command_without_a_time_of_sight_is_refused(folder):
    change_cell(folder, 3, "time_s", "")
    add_command_times(folder, ["", "0.1", "", "", "", ""])
    refused(folder, "line 3, column 'commanded_s': 0.1 s, and time_s is empty; say when the row was seen too")


@pytest.mark.parametrize("column", ["f_u_px", "f_v_px"])
def test_half_a_marker_is_refused(folder, column):
    change_cell(folder, 3, column, "")
    refused(folder, "samples.csv: line 3, column 'f_u_px': one of u and v is empty; give both, or neither")


def test_a_marker_far_outside_the_picture_is_no_pixel(folder):
    change_cell(folder, 3, "f_u_px", "20000")
    refused(folder, "is far outside the 1280x720 picture; pixels are wanted")


def test_a_row_of_another_length_is_named(folder):
    path = folder / "samples.csv"
    path.write_text(path.read_text() + "6,5.0,line,0.1\n")
    refused(folder, "samples.csv: line 8 has 4 cells, the header has 10")


def test_lines_are_counted_as_in_the_file_past_blank_ones(folder):
    path = folder / "samples.csv"
    lines = path.read_text().splitlines()
    path.write_text("\n".join(["# a comment", *lines[:3], "", "far", *lines[3:]]) + "\n")
    refused(folder, "samples.csv: line 6 has 1 cells")


@pytest.mark.parametrize("content", ["", "sample,time_s,trajectory\n"])
def test_a_table_without_rows_is_refused(folder, content):
    (folder / "samples.csv").write_text(content)
    refused(folder, "samples.csv: no rows")


def test_a_table_that_is_no_text_is_refused(folder):
    (folder / "samples.csv").write_bytes(b"\xff\xfe\x00binary")
    refused(folder, "samples.csv: not a CSV file in UTF-8")


@pytest.mark.parametrize(
    "content", [b"{", b"\xff\xfe", b"[" * 100_000], ids=["cut short", "no text", "nested too deep"]
)
def test_a_header_that_is_no_json_is_refused(folder, content):
    (folder / "recording.json").write_bytes(content)
    refused(folder, "recording.json: not JSON")


def test_a_header_that_is_a_list_is_refused(folder):
    (folder / "recording.json").write_text("[]")
    refused(folder, "recording.json: ")


@pytest.mark.parametrize("name", ["recording.json", "samples.csv"])
def test_a_huge_file_is_refused_before_it_is_read(folder, name):
    with (folder / name).open("r+b") as stream:
        stream.truncate(1 << 40)  # a sparse terabyte
    refused(folder, f"{name}: larger than")


def test_another_schema_is_refused(folder):
    change_header(folder, lambda header: header.update(schema="armtwin.recording/2"))
    refused(folder, "recording.json: schema: 'armtwin.recording/1' is wanted, found 'armtwin.recording/2'")


def test_an_unknown_key_is_named_with_the_nearest_one(folder):
    change_header(folder, lambda header: header.update(arm_plane_mm=-80.0))
    refused(folder, "recording.json: unknown key 'arm_plane_mm'; did you mean 'arm_plane_z_mm'?")


def test_a_held_out_trajectory_that_does_not_exist_is_named(folder):
    change_header(folder, lambda header: header.update(held_out=["lime"]))
    refused(
        folder,
        "recording.json: held_out names trajectory 'lime', which samples.csv does not have; did you mean 'line'?",
    )


@pytest.mark.parametrize("key", ["camera", "arm_plane_z_mm"])
def test_pixels_need_the_camera_and_the_plane(folder, key):
    change_header(folder, lambda header: header.pop(key))
    refused(folder, f"recording.json: key '{key}' is missing, samples.csv has markers in pixels")


def test_a_recording_that_measured_nothing_is_refused(folder):
    for column in ("a_u_px", "a_v_px", "f_u_px", "f_v_px"):
        drop_column(folder, column)
    refused(folder, "samples.csv: neither markers (a_u_px, ...) nor measured angles (theta1_meas_rad, ...)")


@pytest.mark.parametrize("noise", [0.0, -0.1, 1e-300, 1e8, "fine"])
def test_the_pixel_noise_is_one_that_a_detector_may_have(folder, noise):
    change_header(folder, lambda header: header.update(pixel_noise_px=noise))
    refused(folder, "recording.json: pixel_noise_px: ")


@pytest.mark.parametrize("plane_z_mm", [-2000.0, -566.0, 1e8])
def test_a_plane_that_the_camera_does_not_look_at_is_refused(folder, plane_z_mm):
    change_header(folder, lambda header: header.update(arm_plane_z_mm=plane_z_mm))
    refused(folder, f"recording.json: arm_plane_z_mm: found {plane_z_mm:g}, which the camera does not look at")


@pytest.mark.parametrize(
    ("key", "value"),
    [("gravity_m_s2", [0.0, -1e9]), ("tip_mass_kg", 1e9), ("link_lengths_mm", [1e9, 1.0, 1.0, 1.0])],
)
def test_an_arm_that_nobody_can_build_is_refused(folder, key, value):
    change_header(folder, lambda header: header["arm"].update({key: value}))
    refused(folder, f"recording.json: arm.{key}")


def test_a_link_without_length_is_refused(folder):
    change_header(folder, lambda header: header["arm"].update(link_lengths_mm=[120.0, 0.0, 38.0, 6.73]))
    refused(folder, "recording.json: arm: link_lengths_mm: found 0 for link 2, at least 0.1 is wanted")


@pytest.mark.parametrize("name", ["", "x" * 201, "a\x1b[31mb"])
def test_a_trajectory_is_named_by_a_few_printable_characters(folder, name):
    path = folder / "samples.csv"
    head, first, *rows = path.read_text().splitlines()
    cells = first.split(",")
    cells[head.split(",").index("trajectory")] = name
    path.write_text("\n".join([head, ",".join(cells), *rows]) + "\n")
    refused(folder, "samples.csv: line 2, column 'trajectory': found ")


def test_a_byte_order_mark_before_the_header_does_no_harm(folder):
    path = folder / "recording.json"
    path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes())
    assert len(read_recording(folder)) > 0


@pytest.mark.parametrize(("column", "value"), [("payload_kg", -5), ("payload_kg", 1e17), ("temperature_c", -5000)])
def test_a_payload_or_temperature_that_no_bench_has_is_refused(folder, column, value):
    path = folder / "samples.csv"
    head, first, *rows = path.read_text().splitlines()
    kept = [name for name in head.split(",") if name != column]
    place = [head.split(",").index(name) for name in kept]
    lines = [",".join([*(row.split(",")[k] for k in place), str(value)]) for row in (first, *rows)]
    path.write_text("\n".join([",".join([*kept, column]), *lines]) + "\n")
    refused(folder, f"samples.csv: line 2, column '{column}': found {float(value):g}, a number from")


def test_nan_in_the_header_is_refused(folder):
    path = folder / "recording.json"
    path.write_text(path.read_text().replace("-80.87", "NaN"))
    refused(folder, "recording.json: arm_plane_z_mm: ")
