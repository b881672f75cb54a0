import numpy as np
import pytest

from armtwin.hardware.bench.posture import joint_angles, link_vectors_mm
from armtwin.models.arm import Arm, nominal_arm
from armtwin.models.camera import project
from armtwin.models.camera_files import nominal_camera
from armtwin.models.coordinate_frames import robot_to_board
from armtwin.models.kinematics import marker_positions

PLANE_Z_MM = -80.87
BASE_MM = np.array([20.0, -30.0, PLANE_Z_MM])  # where A stands must not matter
FOUR_JOINTS = Arm("chain", np.array([60.0, 50.0, 40.0, 30.0]), np.zeros(2))


def pixels_of(arm: Arm, q: np.ndarray) -> dict[str, np.ndarray]:
    points = robot_to_board(marker_positions(arm, q), BASE_MM)
    return dict(zip(arm.marker_names, project(nominal_camera(), points), strict=True))


@pytest.mark.parametrize("arm", [nominal_arm(), FOUR_JOINTS], ids=["planar3", "four joints"])
def test_joint_angles_are_read_back_from_the_markers(arm: Arm):
    for q in np.random.default_rng(0).uniform(-0.5, 0.5, (20, arm.n_joints)):
        links = link_vectors_mm(arm, nominal_camera(), PLANE_Z_MM, pixels_of(arm, q))

        assert links is not None
        np.testing.assert_allclose(joint_angles(arm, links), q, atol=1e-9)


def test_a_hidden_marker_leaves_the_posture_unknown():
    seen = pixels_of(nominal_arm(), np.zeros(3))
    del seen["b"]

    assert link_vectors_mm(nominal_arm(), nominal_camera(), PLANE_Z_MM, seen) is None


def test_a_marker_without_pixels_leaves_the_posture_unknown():
    seen = pixels_of(nominal_arm(), np.zeros(3)) | {"c": np.full(2, np.nan)}

    assert link_vectors_mm(nominal_arm(), nominal_camera(), PLANE_Z_MM, seen) is None
