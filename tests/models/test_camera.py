import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from armtwin.models.camera import (
    Camera,
    back_project,
    project,
    project_jacobian,
    rays_of,
)
from armtwin.models.lenses import PlumbBob

# Table 2, printed as a row-vector matrix with four digits: transposed and made orthonormal for column vectors.
PRINTED_R = np.array([[-0.9988, -0.0047, 0.0496], [0.0041, -0.9999, -0.0129], [0.0497, -0.0127, 0.9987]])
TABLE_2_D = np.array([0.1630, 0.0428, 0.0064, 0.0016, -2.1819])
K = np.array([[1438.6338, 0.0, 654.1560], [0.0, 1439.1291, 369.6557], [0.0, 0.0, 1.0]])
Z_0_MM = -80.87


def orthonormal(R):
    U, _, Vt = np.linalg.svd(R)
    return U @ Vt


CAMERA = Camera(1280, 720, K, PlumbBob(TABLE_2_D), orthonormal(PRINTED_R.T), np.array([118.6608, 41.3400, 565.4370]))
mild_coefficients = st.tuples(
    st.floats(-0.3, 0.3), st.floats(-0.1, 0.1), st.floats(-0.01, 0.01), st.floats(-0.01, 0.01), st.floats(-0.1, 0.1)
).map(np.array)
inside_pixels = st.lists(st.tuples(st.floats(0, 1279), st.floats(0, 719)), min_size=1, max_size=20).map(np.array)


def whole_picture():
    u, v = np.meshgrid(np.linspace(0, 1279, 41), np.linspace(0, 719, 23))
    return np.stack([u.ravel(), v.ravel()], axis=-1)


def board_points(n=50, seed=0):
    rng = np.random.default_rng(seed)
    return rng.uniform([-150, -60, -100], [120, 120, 20], (n, 3))


def test_distortion_is_equation_15_written_out():
    k1, k2, p1, p2, k3 = TABLE_2_D
    x, y = 0.21, -0.13
    r2 = x * x + y * y
    radial = 1 + k1 * r2 + k2 * r2**2 + k3 * r2**3
    # Equation (15) prints r^2 + 2 u^2 in its second row; the model (Brown's, OpenCV's, Matlab's) has r^2 + 2 v^2.
    expected = [
        radial * x + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
        radial * y + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y,
    ]
    np.testing.assert_allclose(PlumbBob(TABLE_2_D).distort(np.array([[x, y]]))[0], expected, atol=1e-15)


def test_projection_is_opencvs():
    points = board_points()
    rvec, _ = cv2.Rodrigues(CAMERA.R_board_camera)
    expected, _ = cv2.projectPoints(points, rvec, CAMERA.t_board_camera_mm, K, TABLE_2_D)
    np.testing.assert_allclose(project(CAMERA, points), expected[:, 0], atol=1e-9)


def test_undistort_inverts_distort_to_1e_10_over_the_whole_picture_of_table_2():
    pixels = whole_picture()
    distorted = (pixels - K[:2, 2]) / np.diag(K)[:2]
    corrected = PlumbBob(TABLE_2_D).undistort(distorted)
    np.testing.assert_allclose(PlumbBob(TABLE_2_D).distort(corrected), distorted, atol=1e-10)


@given(mild_coefficients, st.lists(st.tuples(st.floats(-0.45, 0.45), st.floats(-0.3, 0.3)), min_size=1).map(np.array))
def test_undistort_of_distort_is_the_point_to_1e_10_for_mild_coefficients(D, points):
    np.testing.assert_allclose(PlumbBob(D).undistort(PlumbBob(D).distort(points)), points, atol=1e-10)


def test_points_beyond_the_fold_of_the_polynomial_come_back_as_nan():
    beyond = np.array([[1.5, 0.0], [0.1, 0.1]])
    corrected = PlumbBob(TABLE_2_D).undistort(beyond)
    assert np.isnan(corrected[0]).all()
    assert np.isfinite(corrected[1]).all()


def test_an_unseen_marker_stays_unseen():
    assert np.isnan(back_project(CAMERA, np.array([[np.nan, np.nan]]), Z_0_MM)).all()


@given(mild_coefficients)
def test_the_distortions_derivative_is_that_of_central_differences(D):
    points = np.random.default_rng(0).uniform(-0.4, 0.4, (8, 2))
    J = PlumbBob(D).distort_jacobian(points)
    for k in range(2):
        h = np.eye(2)[k] * 1e-6
        np.testing.assert_allclose(
            J[..., k], (PlumbBob(D).distort(points + h) - PlumbBob(D).distort(points - h)) / 2e-6, atol=1e-8
        )


def test_the_projections_derivative_is_that_of_central_differences():
    points = board_points(10)
    J = project_jacobian(CAMERA, points)
    for k in range(3):
        h = np.eye(3)[k] * 1e-3
        difference = (project(CAMERA, points + h) - project(CAMERA, points - h)) / 2e-3
        np.testing.assert_allclose(J[..., k], difference, atol=1e-7)


@given(st.lists(st.tuples(st.floats(-150, 120), st.floats(-60, 120)), min_size=1, max_size=20), st.floats(-100, 20))
def test_back_projection_onto_its_plane_undoes_projection(xy, z):
    points = np.array([(x, y, z) for x, y in xy])
    np.testing.assert_allclose(back_project(CAMERA, project(CAMERA, points), z), points, atol=1e-7)


@given(inside_pixels)
def test_projection_undoes_back_projection_anywhere_in_the_picture(pixels):
    np.testing.assert_allclose(project(CAMERA, back_project(CAMERA, pixels, Z_0_MM)), pixels, atol=1e-7)


@given(inside_pixels, st.floats(-100, 20))
@settings(max_examples=50)
def test_equation_16_with_the_row_vector_matrix_m_is_back_projection(pixels, z0):
    K_rows = np.array([[K[0, 0], 0, 0], [K[0, 1], K[1, 1], 0], [K[0, 2], K[1, 2], 1]])
    RT_rows = np.vstack([CAMERA.R_board_camera.T, CAMERA.t_board_camera_mm])
    m = RT_rows @ K_rows  # equation (14), 4 x 3
    corrected = rays_of(CAMERA, pixels)[..., :2] @ K[:2, :2].T + K[:2, 2]
    for (u, v), found in zip(corrected, back_project(CAMERA, pixels, z0), strict=True):
        left = np.array(
            [[m[0, 0] - m[0, 2] * u, m[1, 0] - m[1, 2] * u], [m[0, 1] - m[0, 2] * v, m[1, 1] - m[1, 2] * v]]
        )
        right = np.array(
            [
                (m[3, 2] * u - m[3, 0]) + (m[2, 2] * u - m[2, 0]) * z0,
                (m[3, 2] * v - m[3, 1]) + (m[2, 2] * v - m[2, 1]) * z0,
            ]
        )
        np.testing.assert_allclose(np.linalg.solve(left, right), found[:2], atol=1e-6)
        assert found[2] == pytest.approx(z0, abs=1e-9)


def test_a_skewed_camera_normalises_what_it_projects():
    skewed = Camera(1280, 720, K + np.array([[0, 3.0, 0], [0, 0, 0], [0, 0, 0]]), PlumbBob(TABLE_2_D), *pose())
    points = board_points()
    X = points @ skewed.R_board_camera.T + skewed.t_board_camera_mm
    np.testing.assert_allclose(rays_of(skewed, project(skewed, points))[..., :2], X[:, :2] / X[:, 2:], atol=1e-10)


def pose():
    return CAMERA.R_board_camera, CAMERA.t_board_camera_mm


def test_the_centre_of_the_top_left_pixel_is_zero_zero():
    plain = Camera(1280, 720, K, PlumbBob(np.zeros(5)), np.eye(3), np.zeros(3))
    ray = np.array([[-K[0, 2] / K[0, 0], -K[1, 2] / K[1, 1], 1.0]])
    np.testing.assert_allclose(project(plain, ray), [[0.0, 0.0]], atol=1e-12)


def test_the_transform_maps_board_points_to_the_camera_frame():
    point = np.array([10.0, 20.0, -30.0])
    expected = CAMERA.R_board_camera @ point + CAMERA.t_board_camera_mm
    np.testing.assert_allclose((CAMERA.T_board_camera @ np.append(point, 1.0))[:3], expected)


def test_a_moved_camera_sees_the_board_where_the_motion_puts_it():
    rotation, _ = cv2.Rodrigues(np.array([0.01, -0.02, 0.03]))
    shift = np.array([1.0, -2.0, 3.0])
    moved = CAMERA.moved(rotation, shift)
    expected = rotation @ CAMERA.T_board_camera[:3, 3] + shift
    np.testing.assert_allclose(moved.t_board_camera_mm, expected)
    np.testing.assert_allclose(moved.R_board_camera, rotation @ CAMERA.R_board_camera)
    np.testing.assert_array_equal(moved.K, CAMERA.K)


def test_the_arms_plane_is_nearer_to_the_camera_than_the_board():
    board, arm = (CAMERA.R_board_camera @ np.array([0, 0, z]) + CAMERA.t_board_camera_mm for z in (0.0, Z_0_MM))
    assert 470 < arm[2] < 500 < board[2]
