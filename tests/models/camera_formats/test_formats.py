"""Camera files of other programs: the same camera, or a line that says what to do."""

from __future__ import annotations

import json
import os
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from armtwin.models.camera import Camera
from armtwin.models.camera_files import read_camera, write_camera
from armtwin.models.errors import InputError
from armtwin.models.lenses import Equidistant, PlumbBob, Rational, lens_named

CASES = Path(__file__).parents[4] / "shared" / "cases" / "camera-files"
FIVE = [-0.030605, 0.035201, -0.000138, -0.000146, -0.01204]


def read(tmp_path: Path, text: str, name: str = "camera.yaml") -> Camera:
    path = tmp_path / name
    path.write_text(text)
    return read_camera(path)


def refusal(tmp_path: Path, text: str, name: str = "camera.yaml") -> str:
    with pytest.raises(InputError) as caught:
        read(tmp_path, text, name)
    message = str(caught.value)
    assert message.startswith(str(tmp_path / name))
    assert "\n" not in message
    return message


def check(camera: Camera, size: tuple[int, int], focal: tuple[float, float], centre: tuple[float, float]) -> None:
    assert (camera.image_width, camera.image_height) == size
    np.testing.assert_allclose(camera.K, [[focal[0], 0, centre[0]], [0, focal[1], centre[1]], [0, 0, 1]], rtol=1e-15)


@pytest.mark.skipif(not CASES.is_dir(), reason="the shared camera files are absent")
@pytest.mark.parametrize(
    ("name", "size", "model"),
    [
        ("image_pipeline_278_cols5.yaml", (640, 480), "rational_polynomial"),
        ("kalibr_camchain.yaml", (1280, 800), "plumb_bob"),
        ("left.ini", (640, 480), "plumb_bob"),
        ("no_distortion.yaml", (1280, 720), "plumb_bob"),
        ("null_D.yaml", (1280, 720), "plumb_bob"),
        ("opencv14.yml", (1280, 720), "rational_polynomial"),
        ("opencv24.yml", (1280, 720), "plumb_bob"),
        ("opencv_fisheye_sample.yml", (640, 480), "equidistant"),
        ("orbbec_eight_numbers.yaml", (1280, 800), "plumb_bob"),
        ("orbbec_topic_echo.yaml", (1280, 800), "plumb_bob"),
    ],
)
def test_files_that_people_have_are_read(name: str, size: tuple[int, int], model: str) -> None:
    camera = read_camera(CASES / name)
    assert (camera.image_width, camera.image_height) == size
    assert camera.lens.model == model


ECHO = """header:
  stamp: {sec: 1700000000, nanosec: 0}
height: 800
width: 1280
distortion_model: plumb_bob
d: [-0.030605, 0.035201, -0.000138, -0.000146, -0.01204, 0.0, 0.0, 0.0]
k: [612.1, 0.0, 640.5, 0.0, 612.3, 400.2, 0.0, 0.0, 1.0]
binning_x: 0
---
"""


def test_a_message_as_ros_prints_it_is_a_plumb_bob_however_many_zeros_follow(tmp_path: Path) -> None:
    camera = read(tmp_path, ECHO)
    check(camera, (1280, 800), (612.1, 612.3), (640.5, 400.2))
    assert isinstance(camera.lens, PlumbBob)
    np.testing.assert_array_equal(camera.lens.coefficients, FIVE)


def test_many_messages_of_one_camera_are_that_camera_in_capitals_too(tmp_path: Path) -> None:
    camera = read(tmp_path, ECHO.replace("d: [", "D: [").replace("k: [", "K: [") * 3)
    np.testing.assert_array_equal(camera.lens.coefficients, FIVE)


def test_messages_of_two_cameras_are_refused(tmp_path: Path) -> None:
    assert "different cameras" in refusal(tmp_path, ECHO + ECHO.replace("612.1", "700.0"))


def test_a_message_of_binned_pictures_is_refused(tmp_path: Path) -> None:
    assert "binning_x: found 2" in refusal(tmp_path, ECHO.replace("binning_x: 0", "binning_x: 2"))


KALIBR = """cam0:
  cam_overlaps: [1]
  camera_model: pinhole
  distortion_coeffs: [0.1, 0.02, -0.003, 0.0004]
  distortion_model: equidistant
  intrinsics: [1073.5, 1073.25, 639.75, 350.5]
  resolution: [1280, 800]
"""


def test_kalibrs_chain_of_one_camera_is_read(tmp_path: Path) -> None:
    camera = read(tmp_path, KALIBR)
    check(camera, (1280, 800), (1073.5, 1073.25), (639.75, 350.5))
    assert isinstance(camera.lens, Equidistant)
    radtan = read(tmp_path, KALIBR.replace("equidistant", "radtan"))
    np.testing.assert_array_equal(radtan.lens.coefficients, [0.1, 0.02, -0.003, 0.0004, 0.0])


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("pinhole", "omni", "cam0: camera_model: found 'omni', wanted 'pinhole'"),
        ("equidistant", "fov", "cam0: distortion_model: found 'fov', wanted one of radtan"),
        ("350.5]", "350.5, 1.0]", "cam0: intrinsics: found 5 numbers"),
    ],
)
def test_kalibrs_other_models_are_refused_by_name(tmp_path: Path, old: str, new: str, told: str) -> None:
    assert told in refusal(tmp_path, KALIBR.replace(old, new))


def test_kalibrs_chain_of_two_cameras_asks_for_one(tmp_path: Path) -> None:
    assert "found the cameras cam0, cam1" in refusal(tmp_path, KALIBR + KALIBR.replace("cam0", "cam1"))


@pytest.mark.parametrize("suffix", [".yml", ".xml", ".json"])
@pytest.mark.parametrize(
    ("matrix", "distortion", "width", "height"),
    [
        ("camera_matrix", "distortion_coefficients", "image_width", "image_height"),
        ("Camera_Matrix", "Distortion_Coefficients", "image_Width", "image_Height"),
        ("cameraMatrix", "distCoeffs", "imageWidth", "imageHeight"),
    ],
)
def test_what_opencv_writes_is_read_in_each_of_its_syntaxes_and_spellings(
    tmp_path: Path, suffix: str, matrix: str, distortion: str, width: str, height: str
) -> None:
    path = tmp_path / f"camera{suffix}"
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    storage.write(width, 1280)
    storage.write(height, 720)
    storage.write(matrix, np.array([[1002.1, 0.0, 640.2], [0.0, 1001.7, 359.6], [0.0, 0.0, 1.0]]))
    storage.write(distortion, np.array([[0.28, -0.126, 0.0, 0.0, -0.01, 0.55, -0.11, -0.036, *[0.0] * 6]]).T)
    storage.release()
    camera = read_camera(path)
    check(camera, (1280, 720), (1002.1, 1001.7), (640.2, 359.6))
    assert isinstance(camera.lens, Rational)


def test_plain_lists_of_a_python_tutorial_are_read_when_the_size_is_there(tmp_path: Path) -> None:
    text = "camera_matrix: [[500.0, 0, 320.0], [0, 501.0, 240.0], [0, 0, 1]]\ndist_coeff: [[0.1, 0.2, 0.0, 0.0, 0.3]]\n"
    check(read(tmp_path, text + "image_size: [640, 480]\n"), (640, 480), (500.0, 501.0), (320.0, 240.0))
    assert "image_width: found nothing" in refusal(tmp_path, text)


INI = """# Camera intrinsics
[image]

width
640

height
480

[mono_left]

camera matrix
369.5 0.0 320.75
0.0 367.25 203.5
0.0 0.0 1.0

distortion
0.19 -0.018 -0.0006 0.00005 -0.0002
"""


def test_an_ini_file_is_read(tmp_path: Path) -> None:
    camera = read(tmp_path, INI, "left.ini")
    check(camera, (640, 480), (369.5, 367.25), (320.75, 203.5))
    np.testing.assert_array_equal(camera.lens.coefficients, [0.19, -0.018, -0.0006, 0.00005, -0.0002])


def test_an_ini_files_mistake_is_told_by_its_line(tmp_path: Path) -> None:
    assert "line 13: found '369.5 x 320.75'" in refusal(tmp_path, INI.replace("369.5 0.0", "369.5 x"), "left.ini")


DISPLAYED = """  cameraIntrinsics with properties:

             FocalLength: [715.25 711.5]
          PrincipalPoint: [566.5 356.25]
               ImageSize: [712 1072]
        RadialDistortion: [-0.3361 0.0921]
    TangentialDistortion: [0.001 -0.002]
                    Skew: 0
"""


def test_matlab_counts_pixels_from_one_and_rows_first(tmp_path: Path) -> None:
    camera = read(tmp_path, DISPLAYED, "camera.txt")
    check(camera, (1072, 712), (715.25, 711.5), (565.5, 355.25))
    np.testing.assert_array_equal(camera.lens.coefficients, [-0.3361, 0.0921, 0.001, -0.002, 0.0])


def test_matlabs_structure_as_json_is_read_with_its_matrix_transposed(tmp_path: Path) -> None:
    structure = {
        "IntrinsicMatrix": [[715.25, 0, 0], [0, 711.5, 0], [566.5, 356.25, 1]],
        "RadialDistortion": [-0.3361, 0.0921, 0.01],
        "TangentialDistortion": [0, 0],
        "ImageSize": [712, 1072],
    }
    camera = read(tmp_path, json.dumps(structure), "camera.json")
    check(camera, (1072, 712), (715.25, 711.5), (565.5, 355.25))
    assert camera.lens.named["k3"] == 0.01


def test_rows_below_a_name_are_read_with_matlabs_common_factor(tmp_path: Path) -> None:
    text = """IntrinsicMatrix =

   1.0e+03 *

    0.7152         0         0
         0    0.7115         0
    0.5665    0.3562    0.0010

RadialDistortion =

   -0.3361    0.0921

ImageSize: [712 1072]
"""
    camera = read(tmp_path, text, "camera.txt")
    check(camera, (1072, 712), (715.2, 711.5), (565.5, 355.2))
    np.testing.assert_allclose(camera.lens.coefficients, [-0.3361, 0.0921, 0.0, 0.0, 0.0])


def test_bouguets_results_count_from_zero(tmp_path: Path) -> None:
    text = """%-- Focal length:
fc = [ 657.5 ; 657.75 ];
cc = [ 302.25 ; 242.5 ];
alpha_c = 0.0000;
kc = [ -0.2558 ; 0.1276 ; -0.0002 ; 0.00003 ; 0.0 ];
nx = 640;
ny = 480;
"""
    camera = read(tmp_path, text, "Calib_Results.m")
    check(camera, (640, 480), (657.5, 657.75), (302.25, 242.5))
    assert camera.lens.named["p1"] == -0.0002


MRCAL = """# generated on a day with mrcal
{
    'lensmodel':  'LENSMODEL_OPENCV8',

    # intrinsics are fx,fy,cx,cy,distortion0,distortion1,....
    'intrinsics': [ 1761.25, 1761.5, 1965.75, 1087.5, -0.012, 0.025, -0.0003, 0.0005, 0.028, 0.35, 0.09, 0.04,],
    'rt_cam_ref': [ 0., 0., 0., 0., 0., 0., ],
    'imagersize': [ 4000, 2200,],
}
"""


def test_mrcals_model_is_read(tmp_path: Path) -> None:
    camera = read(tmp_path, MRCAL, "camera.cameramodel")
    check(camera, (4000, 2200), (1761.25, 1761.5), (1965.75, 1087.5))
    assert camera.lens.named["k6"] == 0.04


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("OPENCV8", "CAHVORE_linearity=0.34", "lensmodel: found 'LENSMODEL_CAHVORE_linearity=0.34', wanted one of"),
        ("'LENSMODEL_OPENCV8'", "__import__('os').getcwd()", "something else than plain values"),
        ("[ 4000, 2200,]", "[ 4000, 2200,", "line 9: found no Python literal"),
        ("0.09, 0.04", "0.09", "intrinsics: found 11 numbers, wanted 12"),
    ],
)
def test_mrcals_models_that_are_not_held_are_refused_and_nothing_is_run(
    tmp_path: Path, old: str, new: str, told: str
) -> None:
    assert told in refusal(tmp_path, MRCAL.replace(old, new), "x.cameramodel")


ROS = """image_width: 1280
image_height: 720
camera_name: webcam
camera_matrix: {rows: 3, cols: 3, data: [701.5, 0.0, 625.75, 0.0, 701.5, 352.5, 0.0, 0.0, 1.0]}
distortion_model: plumb_bob
distortion_coefficients: {rows: 1, cols: 5, data: [0.1, 0.2, 0.0, 0.0, 0.3]}
"""


@pytest.mark.parametrize("model", ["''", "none", "plumb_bob", "null"])
@pytest.mark.parametrize("numbers", ["null", "{rows: 1, cols: 0, data: []}", "[]"])
def test_a_rectified_camera_has_no_distortion(tmp_path: Path, model: str, numbers: str) -> None:
    text = ROS.replace("plumb_bob", model).replace("{rows: 1, cols: 5, data: [0.1, 0.2, 0.0, 0.0, 0.3]}", numbers)
    np.testing.assert_array_equal(read(tmp_path, text).lens.coefficients, np.zeros(5))


def test_a_camera_that_was_never_calibrated_is_named_as_that(tmp_path: Path) -> None:
    text = ROS.replace("701.5, 0.0, 625.75, 0.0, 701.5, 352.5, 0.0, 0.0, 1.0", ", ".join(["0.0"] * 9))
    assert "never calibrated; photograph a chessboard and run `armtwin calibrate-camera`" in refusal(tmp_path, text)


def test_eight_numbers_in_five_columns_are_image_pipelines_rational_model(tmp_path: Path) -> None:
    text = ROS.replace("plumb_bob", "rational_polynomial").replace("0.0, 0.3]", "0.0, 0.3, 0.54, -0.02, 0.01]")
    assert isinstance(read(tmp_path, text).lens, Rational)


@pytest.mark.parametrize(
    "line", ["distortion_model: equidistant", "camera_model: fisheye", "distortion_model: fisheye"]
)
def test_a_fisheye_is_told_by_either_of_image_pipelines_words(tmp_path: Path, line: str) -> None:
    text = ROS.replace("distortion_model: plumb_bob", line).replace("cols: 5, data: [0.1, ", "cols: 4, data: [")
    camera = read(tmp_path, text)
    assert isinstance(camera.lens, Equidistant)
    write_camera(tmp_path / "again.yml", camera)
    assert isinstance(read_camera(tmp_path / "again.yml").lens, Equidistant)


def test_a_fisheye_that_calls_itself_plumb_bob_is_refused(tmp_path: Path) -> None:
    told = refusal(tmp_path, ROS + "camera_model: fisheye\n")
    assert "distortion_model: found 'plumb_bob' beside camera_model 'fisheye'" in told


@pytest.mark.parametrize("count", [12, 14])
@pytest.mark.parametrize("suffix", [".yaml", ".yml"])
def test_a_thin_prism_is_told_by_its_number_of_coefficients(tmp_path: Path, count: int, suffix: str) -> None:
    lens = lens_named("rational_polynomial", 0.01 * np.arange(1.0, count + 1.0))
    write_camera(tmp_path / f"camera{suffix}", replace(read(tmp_path, ROS), lens=lens))
    again = read_camera(tmp_path / f"camera{suffix}").lens
    assert type(again) is type(lens)
    np.testing.assert_array_equal(again.coefficients, lens.coefficients)
    if suffix == ".yaml":
        assert "distortion_model: rational_polynomial\n" in (tmp_path / "camera.yaml").read_text()


def test_models_that_are_not_held_are_named_with_what_to_do(tmp_path: Path) -> None:
    scaramuzza = "fisheyeIntrinsics\n MappingCoefficients: [880 -3e-4 0 0]\n RadialDistortion: []\n"
    assert "fisheyeIntrinsics (Scaramuzza's model), wanted cameraIntrinsics" in refusal(tmp_path, scaramuzza, "f.txt")
    stereo = "M1: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [1, 0, 0, 0, 1, 0, 0, 0, 1]\nM2: 1\n"
    assert "stereo cameras M1 and M2, wanted one" in refusal(tmp_path, stereo, "intrinsics.yml")
    omni = ROS.replace("plumb_bob", "omnidirectional")
    assert "found 'omnidirectional', wanted one of plumb_bob" in refusal(tmp_path, omni)


def test_a_skew_is_kept(tmp_path: Path) -> None:
    assert read(tmp_path, ROS.replace("701.5, 0.0, 625.75", "701.5, 3.5, 625.75")).K[0, 1] == 3.5


def test_a_file_in_utf_16_is_read(tmp_path: Path) -> None:
    (tmp_path / "camera.yaml").write_text(ROS, encoding="utf-16")
    assert read_camera(tmp_path / "camera.yaml").image_width == 1280


@pytest.mark.parametrize("head", ["", "%YAML:1.0\n---\n", "# a comment\n\n"])
def test_lines_are_counted_from_the_files_first(tmp_path: Path, head: str) -> None:
    line = head.count("\n") + 4
    assert f"line {line}: found no valid YAML" in refusal(tmp_path, head + ROS.replace("data: [701.5", "data: ]701.5"))


def test_a_yaml_whose_aliases_unfold_without_end_is_refused_at_once(tmp_path: Path) -> None:
    levels = [f"{chr(98 + i)}: &{chr(98 + i)} [{', '.join([f'*{chr(97 + i)}'] * 9)}]\n" for i in range(11)]
    told = refusal(tmp_path, "a: &a [x, x, x]\n" + "".join(levels) + "camera_matrix: *l\n")
    assert "its aliases unfold to more than" in told
    assert "aliases unfold" in refusal(tmp_path, "a: &a [*a]\ncamera_matrix: *a\n")


def test_an_alias_of_a_plain_list_is_read(tmp_path: Path) -> None:
    text = ECHO.replace("k: [", "p: &k [").replace("binning_x", "k: *k\nbinning_x")
    assert read(tmp_path, text).K[0, 0] == 612.1


def test_xml_with_entities_and_a_pipe_are_refused(tmp_path: Path) -> None:
    bomb = "<?xml version='1.0'?><!DOCTYPE a [<!ENTITY b 'c'>]><a>&b;</a>"
    assert "document type declaration" in refusal(tmp_path, bomb, "camera.xml")
    os.mkfifo(tmp_path / "pipe.yaml")
    with pytest.raises(InputError, match="no plain file"):
        read_camera(tmp_path / "pipe.yaml")


def test_keys_of_no_known_format_are_named(tmp_path: Path) -> None:
    assert "found the keys servo, pin" in refusal(tmp_path, "servo: 1\npin: 9\n")
