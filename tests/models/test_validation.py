import pytest
from pydantic import Field

from armtwin.models.errors import InputError
from armtwin.models.validation import ArmTable, CameraTable, Positive, Strict, check

ARM = {"name": "planar3", "link_lengths_mm": [120.0, 121.7, 38.0, 6.73], "gravity_m_s2": [0.0, 0.0]}
CAMERA = {
    "image_width": 1280,
    "image_height": 720,
    "camera_matrix": [[1438.6, 0.0, 654.2], [0.0, 1439.1, 369.7], [0.0, 0.0, 1.0]],
    "distortion_model": "plumb_bob",
    "distortion_coefficients": [0.163, 0.0428, 0.0064, 0.0016, -2.1819],
    "board_to_camera_rotation": [[-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]],
    "board_to_camera_translation_mm": [118.7, 41.3, 565.4],
}


class Inner(Strict):
    width_rad: Positive


class Outer(Strict):
    inner: Inner
    inners: list[Inner] = Field(default_factory=list)
    sizes: list[list[Positive]] | None = None
    kind: str = Field(alias="type")


def test_good_tables_pass():
    assert check(ArmTable, ARM, "x").name == "planar3"
    assert check(CameraTable, CAMERA, "x").image_width == 1280


def test_an_unknown_key_is_named_with_the_nearest_valid_one_of_its_own_table():
    with pytest.raises(InputError) as error:
        check(Outer, {"inner": {"width_deg": 1.0, "width_rad": 1.0}, "type": "x"}, "file.toml")
    assert str(error.value) == "file.toml: unknown key 'inner.width_deg'; did you mean 'width_rad'?"


def test_a_key_with_nothing_near_lists_the_valid_ones_as_the_file_spells_them():
    with pytest.raises(InputError, match=r"unknown key 'zzzz'; valid names are inner, inners, sizes, type$"):
        check(Outer, {"inner": {"width_rad": 1.0}, "type": "x", "zzzz": 1}, "file.toml")


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ({"width_rad": -1}, "inner 2: width_rad: more than 0 is wanted, found -1"),
        ({}, "inner 2: key 'width_rad' is missing"),
        ({"width_rad": 1, "width_rda": 1}, "inner 2: unknown key 'width_rda'; did you mean 'width_rad'?"),
        (3, "inner 2: a table of keys and values is wanted, found 3"),
    ],
)
def test_the_tables_of_a_list_are_counted_from_1(table, message):
    with pytest.raises(InputError) as error:
        check(Outer, {"inner": {"width_rad": 1}, "type": "x", "inners": [{"width_rad": 1}, table]}, "file.toml")
    assert str(error.value) == f"file.toml: {message}"


def test_the_entries_of_a_list_are_counted_from_1():
    with pytest.raises(InputError, match=r"file\.toml: sizes entry 1: entry 2: more than 0 is wanted, found 0$"):
        check(Outer, {"inner": {"width_rad": 1}, "type": "x", "sizes": [[1, 0]]}, "file.toml")


def test_a_key_of_thousands_of_characters_is_cut():
    with pytest.raises(InputError) as error:
        check(Outer, {"inner": {"width_rad": 1}, "type": "x", "x" * 5000: 1}, "file.toml")
    assert len(str(error.value)) < 200


def test_a_missing_key_is_named():
    with pytest.raises(InputError, match=r"file\.toml: key 'inner\.width_rad' is missing$"):
        check(Outer, {"inner": {}, "type": "x"}, "file.toml")


def test_a_wrong_value_is_shown_with_what_was_wanted():
    with pytest.raises(InputError, match=r"file\.toml: inner\.width_rad: more than 0 is wanted, found -1\.0$"):
        check(Outer, {"inner": {"width_rad": -1.0}, "type": "x"}, "file.toml")


def test_further_faults_are_counted_and_long_values_cut():
    with pytest.raises(InputError) as error:
        check(Outer, {"inner": {"width_rad": "x" * 500}, "type": 3}, "file.toml")
    assert "(and 1 more)" in str(error.value)
    assert len(str(error.value)) < 250


@pytest.mark.parametrize("value", ["1", True, None, [1]], ids=["text", "true", "nothing", "list"])
def test_only_numbers_pass_for_numbers(value):
    with pytest.raises(InputError, match=r"file\.toml: inner\.width_rad: a number is wanted, found "):
        check(Outer, {"inner": {"width_rad": value}, "type": "x"}, "file.toml")


def test_an_int_passes_for_a_float():
    assert check(Inner, {"width_rad": 2}, "x").width_rad == 2.0


def test_an_image_size_may_be_written_with_a_decimal_point_as_json_does_not_tell_the_two_apart():
    assert check(CameraTable, {**CAMERA, "image_width": 1280.0}, "x").image_width == 1280
    for value in (1280.5, "1280", True):
        with pytest.raises(InputError, match="image_width: a whole number is wanted"):
            check(CameraTable, {**CAMERA, "image_width": value}, "x")


@pytest.mark.parametrize("data", [[], 3, "text", None], ids=["list", "number", "text", "nothing"])
def test_what_is_no_table_at_all_is_refused_in_one_line(data):
    with pytest.raises(InputError, match=r"^file\.toml: ") as error:
        check(Outer, data, "file.toml")
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("link_lengths_mm", [0.12, 0.1217, 0.038, 0.00673], "look like metres: multiply by 1000"),
        ("link_lengths_mm", [120.0, 121.7, 38.0], r"needs 4 entries \(l1, l2, l4, l5\), found 3"),
        ("link_lengths_mm", [], "at least 1 entries"),
        ("link_lengths_mm", [float("inf")] * 4, "finite"),
        ("gravity_m_s2", [0.0, 0.0, -9.81], "at most 2 entries"),
        ("link_masses_kg", [0.1, 0.1], "needs 3 entries, one a link, found 2"),
        ("tip_mass_kg", -0.1, "at least 0 is wanted, found -0.1"),
        ("name", "", "at least 1 character"),
    ],
)
def test_arm_tables_that_no_arm_can_have_are_refused(key, value, message):
    with pytest.raises(InputError, match=message):
        check(ArmTable, {**ARM, key: value}, "arm.toml")


def test_a_chain_has_at_most_six_joints():
    with pytest.raises(InputError, match="holds 7 entries, an arm has 1 to 6 joints"):
        check(ArmTable, {"name": "chain", "link_lengths_mm": [10.0] * 7}, "arm.toml")


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("camera_matrix", [[1.0, 0.0], [0.0, 1.0]], "must be a 3x3 matrix"),
        ("camera_matrix", [[-1438.6, 0, 654], [0, 1439, 369], [0, 0, 1]], "fx, fy > 0"),
        ("camera_matrix", [[1438.6, 0, 0], [0, 1439, 0], [654, 369, 1]], "fx, fy > 0"),
        ("distortion_coefficients", [0.1, 0.1], "found 2 numbers for 'plumb_bob', wanted 0, 4, 5, 8, 12 or 14"),
        ("distortion_coefficients", [0.1, 0.1, float("nan"), 0.0, 0.0], "finite"),
        ("distortion_model", "fisheye", "plumb_bob"),
        ("board_to_camera_rotation", [[1.0, 0, 0], [0, 1, 0], [0, 0, -1]], "is no rotation .* determinant -1"),
        ("board_to_camera_rotation", [[2.0, 0, 0], [0, 2, 0], [0, 0, 2]], "is no rotation"),
        ("board_to_camera_translation_mm", [0.1187, 0.0413, 0.5654], "looks like metres"),
        ("image_width", 0, "at least 16 is wanted"),
    ],
)
def test_camera_tables_that_no_camera_can_have_are_refused(key, value, message):
    with pytest.raises(InputError, match=message):
        check(CameraTable, {**CAMERA, key: value}, "recording.json")


def test_table_2s_rounded_rotation_is_near_enough():
    printed = [[-0.9988, 0.0041, 0.0497], [-0.0047, -0.9999, -0.0127], [0.0496, -0.0129, 0.9987]]
    assert check(CameraTable, {**CAMERA, "board_to_camera_rotation": printed}, "x").board_to_camera_rotation == printed
