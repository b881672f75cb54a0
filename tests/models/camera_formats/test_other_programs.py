"""Cameras as other programs of vision keep them: one number a name, one line a camera, arrays of NumPy."""

from __future__ import annotations

import json
import pickle
from pathlib import Path

import cv2
import numpy as np
import pytest

from armtwin.models.camera_files import read_camera
from armtwin.models.errors import InputError
from armtwin.models.lenses import Equidistant, PlumbBob

K = np.array([[1002.1, 0.0, 640.2], [0.0, 1001.7, 359.6], [0.0, 0.0, 1.0]])
D = np.array([-0.1, 0.05, 0.001, -0.0005, 0.0])

VINS = """%YAML:1.0
---
model_type: PINHOLE
image_width: 1280
image_height: 720
distortion_parameters: {k1: -0.1, k2: 0.05, p1: 0.001, p2: -0.0005}
projection_parameters: {fx: 1002.1, fy: 1001.7, cx: 640.2, cy: 359.6}
"""
ORB_SLAM2 = """%YAML:1.0

Camera.fx: 1002.1
Camera.fy: 1001.7
Camera.cx: 640.2
Camera.cy: 359.6
Camera.k1: -0.1
Camera.k2: 0.05
Camera.p1: 0.001
Camera.p2: -0.0005
Camera.width: 1280
Camera.height: 720
"""
ORB_SLAM3 = (
    ORB_SLAM2.replace("Camera.", "Camera1.")
    .replace("Camera1.width", "Camera.width")
    .replace("Camera1.height", 'Camera.type: "PinHole"\nCamera.height')
)
REALSENSE = json.dumps(
    {"width": 1280, "height": 720, "ppx": 640.2, "ppy": 359.6, "fx": 1002.1, "fy": 1001.7}
    | {"model": "distortion.brown_conrady", "coeffs": D.tolist()}
)
NERFSTUDIO = json.dumps(
    {"camera_model": "OPENCV", "fl_x": 1002.1, "fl_y": 1001.7, "cx": 640.7, "cy": 360.1, "w": 1280, "h": 720}
    | {"k1": -0.1, "k2": 0.05, "p1": 0.001, "p2": -0.0005, "frames": []}
)
COLMAP = """# Camera list with one line of data per camera:
#   CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]
1 OPENCV 1280 720 1002.1 1001.7 640.7 360.1 -0.1 0.05 0.001 -0.0005
"""


@pytest.mark.parametrize(
    "text",
    [VINS, ORB_SLAM2, ORB_SLAM3, REALSENSE, NERFSTUDIO, COLMAP],
    ids=["vins", "orb2", "orb3", "realsense", "nerf", "colmap"],
)
def test_one_camera_reads_alike_from_every_program(tmp_path: Path, text: str) -> None:
    path = tmp_path / "camera"
    path.write_text(text, "utf-8")
    _same(path)


def test_the_arrays_of_an_opencv_tutorial_are_a_camera(tmp_path: Path) -> None:
    path = tmp_path / "calibration.npz"
    corners = np.zeros((40, 54, 2))
    np.savez(path, mtx=K, dist=D[None], rvecs=corners, image_size=[1280, 720])
    _same(path)


def test_a_size_written_as_a_matrix_of_opencv_is_a_size(tmp_path: Path) -> None:
    path = tmp_path / "intrinsics.yml"
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    for name, array in {"cameraMatrix": K, "distCoeffs": D, "imageSize": np.array([1280, 720])}.items():
        storage.write(name, array)
    storage.release()
    _same(path)


def test_a_kannala_brandt_lens_of_vins_is_equidistant(tmp_path: Path) -> None:
    path = tmp_path / "fisheye.yaml"
    path.write_text(
        "model_type: KANNALA_BRANDT\nimage_width: 640\nimage_height: 480\n"
        "projection_parameters: {k2: 0.01, k3: -0.02, k4: 0.003, k5: 0.0, mu: 300.5, mv: 300.1, u0: 320.0, v0: 240.0}\n"
    )
    camera = read_camera(path)
    assert isinstance(camera.lens, Equidistant)
    np.testing.assert_array_equal(camera.lens.coefficients, [0.01, -0.02, 0.003, 0.0])


@pytest.mark.parametrize(
    ("name", "raw", "said"),
    [
        ("camera.p", pickle.dumps({"mtx": K, "dist": D}), "never loaded"),
        ("K.npy", b"\x93NUMPY\x01\x00", "np.savez"),
        ("camera.mat", b"MATLAB 5.0 MAT-file, Platform: GLNXA64", "jsonencode"),
        ("broken.npz", b"PK\x03\x04 and no more", "no archive of NumPy"),
        ("oak.json", b'{"cameraData": [[0, {"width": 1280}]]}', "copy one camera's intrinsicMatrix"),
        ("two.txt", COLMAP.encode() + b"2 PINHOLE 640 480 500 500 320 240\n", "keep the line of one"),
        ("fov.txt", b"1 FOV 640 480 500 500 320 240 0.9\n", "wanted one of SIMPLE_PINHOLE"),
        ("short.txt", b"1 OPENCV 640 480 500 500 320 240\n", "found 4 numbers of OPENCV"),
        ("rs.json", REALSENSE.replace("brown", "inverse_brown").encode(), "none of OpenCV's lenses"),
        ("unsized.json", b'{"mtx": [[500,0,320],[0,500,240],[0,0,1]], "dist": [0,0,0,0,0]}', "add image_width and"),
        ("metashape.xml", b"<calibration><projection>frame</projection><f>1000</f></calibration>", "Metashape"),
    ],
)
def test_what_is_not_held_is_named_with_a_way_out(tmp_path: Path, name: str, raw: bytes, said: str) -> None:
    path = tmp_path / name
    path.write_bytes(raw)
    with pytest.raises(InputError) as caught:
        read_camera(path)
    assert said in str(caught.value)
    assert str(caught.value).startswith(str(path))
    assert "\n" not in str(caught.value)


def _same(path: Path) -> None:
    camera = read_camera(path)
    assert (camera.image_width, camera.image_height) == (1280, 720)
    np.testing.assert_allclose(camera.K, K, atol=1e-9)
    assert isinstance(camera.lens, PlumbBob)
    np.testing.assert_allclose(camera.lens.coefficients, D, atol=1e-12)
