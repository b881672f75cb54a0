"""Camera files keep every number, are read by the tools they come from, and say what is wrong with them."""

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from armtwin.models.camera import Camera, project
from armtwin.models.camera_files import MAX_FILE_BYTES, nominal_camera, read_camera, write_camera
from armtwin.models.errors import InputError
from armtwin.models.lenses import PlumbBob

CHESSBOARD = Path(__file__).resolve().parents[2].parent / "shared" / "data" / "chessboard"

finite = st.floats(allow_nan=False, allow_infinity=False)
focal = st.floats(min_value=1e-300, max_value=1e300)
# Control characters and lone surrogates, too: file names hold them.
anything = st.text(st.characters(), max_size=40)
angle = st.floats(min_value=-3.0, max_value=3.0)


@st.composite
def cameras(draw):
    fx, fy, skew, cx, cy = draw(focal), draw(focal), draw(finite), draw(finite), draw(finite)
    rotation, _ = cv2.Rodrigues(np.array([draw(angle), draw(angle), draw(angle)]))
    return Camera(
        image_width=draw(st.integers(1, 65536)),
        image_height=draw(st.integers(1, 65536)),
        K=np.array([[fx, skew, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]]),
        lens=PlumbBob(np.array([draw(finite) for _ in range(5)])),
        R_board_camera=rotation,
        t_board_camera_mm=np.array([draw(finite) for _ in range(3)]),
    )


def assert_same(a: Camera, b: Camera) -> None:
    assert (a.image_width, a.image_height) == (b.image_width, b.image_height)
    assert a.lens.model == b.lens.model
    np.testing.assert_array_equal(a.lens.coefficients, b.lens.coefficients, strict=True)
    for field in ("K", "R_board_camera", "t_board_camera_mm"):
        np.testing.assert_array_equal(getattr(a, field), getattr(b, field), strict=True)


@pytest.mark.parametrize("suffix", [".yaml", ".yml"])
@given(camera=cameras(), name=anything, comment=anything)
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_a_camera_reads_back_exactly_as_written(tmp_path, suffix, camera, name, comment):
    path = tmp_path / f"camera{suffix}"
    write_camera(path, camera, name, comment)
    assert_same(read_camera(path), camera)


def test_ros_file_holds_the_keys_of_camera_info(tmp_path):
    path = tmp_path / "camera.yaml"
    write_camera(path, nominal_camera(), name="webcam")
    content = yaml.safe_load(path.read_text())
    assert content["camera_name"] == "webcam"
    assert content["distortion_model"] == "plumb_bob"
    assert (content["distortion_coefficients"]["rows"], content["distortion_coefficients"]["cols"]) == (1, 5)
    assert content["rectification_matrix"]["data"] == [1, 0, 0, 0, 1, 0, 0, 0, 1]
    P = np.reshape(content["projection_matrix"]["data"], (3, 4))
    np.testing.assert_array_equal(P[:, :3], nominal_camera().K)


def test_small_numbers_are_numbers_to_plain_yaml_1_1_readers_too(tmp_path):
    path, D = tmp_path / "camera.yaml", np.array([1e-05, -3e-17, 2.5e-8, 1e300, -0.0])
    write_camera(path, replace(nominal_camera(), lens=PlumbBob(D)))
    assert yaml.safe_load(path.read_text())["distortion_coefficients"]["data"] == D.tolist()


def test_opencv_reads_what_is_written(tmp_path):
    path, camera = tmp_path / "camera.yml", nominal_camera()
    write_camera(path, camera, comment="made for a test")
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_READ)
    np.testing.assert_allclose(storage.getNode("camera_matrix").mat(), camera.K, rtol=1e-15)
    np.testing.assert_allclose(
        storage.getNode("distortion_coefficients").mat().ravel(), camera.lens.coefficients, rtol=1e-15
    )
    assert storage.getNode("image_width").real() == 1280


def test_what_opencv_writes_is_read(tmp_path):
    path, camera = tmp_path / "camera.yml", nominal_camera()
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    storage.write("image_width", 1280)
    storage.write("image_height", 720)
    storage.write("camera_matrix", camera.K)
    storage.write("distortion_coefficients", camera.lens.coefficients.reshape(5, 1) * 1e-9)  # numbers with exponents
    storage.release()
    found = read_camera(path)
    np.testing.assert_array_equal(found.K, camera.K)
    np.testing.assert_allclose(found.lens.coefficients, camera.lens.coefficients * 1e-9, rtol=1e-15)
    np.testing.assert_array_equal(found.T_board_camera, np.eye(4))


@pytest.mark.skipif(not CHESSBOARD.is_dir(), reason="the shared chessboard photographs are absent")
def test_opencv_sample_of_published_intrinsics_is_read():
    camera = read_camera(CHESSBOARD / "published_intrinsics.yml")
    assert (camera.image_width, camera.image_height) == (640, 480)
    np.testing.assert_allclose(camera.K[[0, 1, 0, 1], [0, 1, 2, 2]], [535.92, 535.92, 342.28, 235.57], atol=0.005)
    np.testing.assert_allclose(camera.lens.coefficients, [-0.26637, -0.03859, 0.00178, -0.00028, 0.23839], atol=1e-5)


def test_four_coefficients_mean_no_sixth_power_and_plain_exponents_are_numbers(tmp_path):
    path = tmp_path / "camera.yaml"
    text = camera_text().replace(
        "cols: 5\n   data: [0.1, 0.2, 0.3, 0.4, 0.5]", "cols: 4\n   data: [1e-05, 2E3, 3, -4e+1]"
    )
    path.write_text(text)
    np.testing.assert_array_equal(read_camera(path).lens.coefficients, [1e-05, 2e3, 3.0, -40.0, 0.0])


class TestNominalWebcam:
    # Table 2 as printed: rows of MATLAB's matrix, which multiplies row vectors.
    PRINTED = np.array([[-0.9988, -0.0047, 0.0496], [0.0041, -0.9999, -0.0129], [0.0497, -0.0127, 0.9987]])

    def test_intrinsics_and_translation_are_table_2(self):
        camera = nominal_camera()
        np.testing.assert_array_equal(camera.K, [[1438.6338, 0, 654.1560], [0, 1439.1291, 369.6557], [0, 0, 1]])
        np.testing.assert_array_equal(camera.t_board_camera_mm, [118.6608, 41.3400, 565.4370])

    def test_rotation_is_the_printed_one_transposed_and_made_orthonormal(self):
        R = nominal_camera().R_board_camera
        np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-15)
        assert np.linalg.det(R) > 0
        np.testing.assert_allclose(R, self.PRINTED.T, atol=5.0e-5)  # the rounding of four digits

    def test_projection_is_equation_13_with_row_vectors(self):
        camera = replace(nominal_camera(), lens=PlumbBob(np.zeros(5)))
        point = np.array([46.0, 69.0, 0.0])
        K_row = camera.K.T
        w_uv = (np.append(point, 1.0) @ np.vstack([self.PRINTED, camera.t_board_camera_mm])) @ K_row
        # A board of 200 mm turned by the rounding error of 5e-5 moves by 0.01 mm, 0.03 px.
        np.testing.assert_allclose(project(camera, point[None])[0], w_uv[:2] / w_uv[2], atol=0.05)

    def test_distortion_is_in_opencv_order(self):
        camera = nominal_camera()
        # The paper's order is k1, k2, k3, p1, p2.
        k1, k2, k3, p1, p2 = 0.1630, 0.0428, -2.1819, 0.0064, 0.0016
        np.testing.assert_array_equal(camera.lens.coefficients, [k1, k2, p1, p2, k3])
        points = np.array([[0.0, 0.0, 0.0], [184.0, 115.0, 0.0], [92.0, -40.0, -80.87]])
        rvec, _ = cv2.Rodrigues(camera.R_board_camera)
        expected, _ = cv2.projectPoints(points, rvec, camera.t_board_camera_mm, camera.K, camera.lens.coefficients)
        np.testing.assert_allclose(project(camera, points), expected.reshape(-1, 2), atol=1e-9)

    def test_the_whole_board_is_in_the_picture(self):
        x, y = np.meshgrid(np.arange(-1, 10) * 23.0, np.arange(-1, 7) * 23.0)
        pixels = project(nominal_camera(), np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=1))
        assert np.all(pixels > 0)
        assert np.all(pixels < [1279, 719])


def camera_text() -> str:
    return (
        "image_width: 640\nimage_height: 480\ncamera_name: c\n"
        "camera_matrix:\n   rows: 3\n   cols: 3\n   data: [500.0, 0.0, 320.0, 0.0, 500.0, 240.0, 0.0, 0.0, 1.0]\n"
        "distortion_model: plumb_bob\n"
        "distortion_coefficients:\n   rows: 1\n   cols: 5\n   data: [0.1, 0.2, 0.3, 0.4, 0.5]\n"
        "board_to_camera_rotation:\n   rows: 3\n   cols: 3\n   data: [1, 0, 0, 0, 1, 0, 0, 0, 1]\n"
        "board_to_camera_translation_mm:\n   rows: 3\n   cols: 1\n   data: [1, 2, 3]\n"
    )


@pytest.mark.parametrize(
    ("old", "new", "key"),
    [
        ("image_width: 640\n", "", "image_width"),
        ("image_width: 640", "image_width: 640.5", "image_width"),
        ("image_height: 480", "image_height: 0", "image_height"),
        ("image_height: 480", "image_height: true", "image_height"),
        ("image_height: 480", "image_height: 1000000", "image_height"),
        ("plumb_bob", "omni", "distortion_model"),
        ("500.0, 0.0, 320.0", "-500.0, 0.0, 320.0", "camera_matrix"),
        ("500.0, 0.0, 320.0", ".nan, 0.0, 320.0", "camera_matrix"),
        ("500.0, 0.0, 320.0", "f, 0.0, 320.0", "camera_matrix"),
        ("500.0, 0.0, 320.0", "1" + "0" * 400 + ", 0.0, 320.0", "camera_matrix"),
        ("500.0, 0.0, 320.0", "0.0, 320.0", "camera_matrix"),
        ("camera_matrix:", "camera_matrix_:", "camera_matrix"),
        ("cols: 5\n", "cols: 4\n", "distortion_coefficients"),
        ("cols: 5\n", "cols: five\n", "distortion_coefficients"),
        ("cols: 5\n   data: [", "cols: 7\n   data: [0, 0, ", "distortion_coefficients"),
        ("[1, 0, 0, 0, 1", "[1.001, 0, 0, 0, 1", "board_to_camera_rotation"),
        ("[1, 0, 0, 0, 1", "[-1, 0, 0, 0, 1", "board_to_camera_rotation"),
        ("rows: 3\n   cols: 1\n   data: [1, 2, 3]", "rows: 1\n   cols: 3\n   data: [1, 2, 3]", "translation_mm"),
        ("board_to_camera_translation_mm:", "translation:", "board_to_camera_translation_mm"),
        ("camera_name: c", "camera_name: [", "valid YAML"),
        ("camera_name: c", "camera_name: " + "[" * 5000, "valid YAML"),
        ("camera_name: c", "camera_name: 2001-99-99", "valid YAML"),
        ("camera_name: c", "camera_name: !!python/object/apply:os.getcwd []", "valid YAML"),
    ],
)
def test_a_wrong_file_is_refused_by_name_and_key(tmp_path, old, new, key):
    path = tmp_path / "camera.yaml"
    assert old in camera_text()
    path.write_text(camera_text().replace(old, new, 1))
    with pytest.raises(InputError, match=key) as caught:
        read_camera(path)
    message = str(caught.value)
    assert message.startswith(str(path))
    assert "found" in message
    assert "wanted" in message
    assert "\n" not in message


@pytest.mark.parametrize("content", [b"", b"- 1\n- 2\n", b"\xff\xfe\x00\x01", b"text"])
def test_what_is_no_camera_file_is_refused(tmp_path, content):
    path = tmp_path / "camera.yaml"
    path.write_bytes(content)
    with pytest.raises(InputError, match=r"wanted (a camera file|keys)"):
        read_camera(path)


def test_a_missing_file_and_a_folder_are_refused(tmp_path):
    for path in (tmp_path / "none.yaml", tmp_path):
        with pytest.raises(InputError, match="cannot be read"):
            read_camera(path)


def test_an_oversized_file_is_refused(tmp_path):
    path = tmp_path / "camera.yaml"
    path.write_bytes(b"#" * (MAX_FILE_BYTES + 1))
    with pytest.raises(InputError, match="bytes"):
        read_camera(path)


def test_another_suffix_is_not_written(tmp_path):
    with pytest.raises(InputError, match="suffix"):
        write_camera(tmp_path / "camera.txt", nominal_camera())
    assert list(tmp_path.iterdir()) == []
