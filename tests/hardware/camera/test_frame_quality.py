from pathlib import Path

import cv2
import numpy as np
import pytest

from armtwin.hardware.bench.tables import QualityTable
from armtwin.hardware.camera.frame_quality import edge_width_px, fault_of
from armtwin.hardware.camera.stillness import to_grey

BOUNDS = QualityTable()
PHOTOGRAPHS = sorted((Path(__file__).parents[4] / "shared" / "data" / "chessboard").glob("*.jpg"))


def test_a_good_picture_passes(scene):
    assert fault_of(to_grey(scene.picture()), BOUNDS) is None


def test_black_is_refused(scene):
    dark = (scene.picture() * 0.03).astype(np.uint8)

    assert "black" in str(fault_of(to_grey(dark), BOUNDS))


def test_over_exposed_is_refused(scene):
    bright = np.clip(scene.picture().astype(int) * 4, 0, 255).astype(np.uint8)

    assert "over-exposed" in str(fault_of(to_grey(bright), BOUNDS))


def test_blurred_is_refused(scene):
    blurred = cv2.GaussianBlur(scene.picture(), (0, 0), 4.0)

    assert "blurred" in str(fault_of(to_grey(blurred), BOUNDS))


def test_a_wall_without_edges_is_refused_as_blurred():
    assert "no edges" in str(fault_of(np.full((360, 640), 120, np.uint8), BOUNDS))


@pytest.mark.parametrize("sigma", [2.0, 3.0, 4.0])
def test_edge_width_follows_the_blur(scene, sigma: float):
    """A Gaussian edge is sigma sqrt(2 pi) wide; the picture's own edge and the smoothing add a little in quadrature."""
    width = edge_width_px(to_grey(cv2.GaussianBlur(scene.picture(), (0, 0), sigma)))

    assert width == pytest.approx(np.hypot(sigma * np.sqrt(2 * np.pi), 2.0), rel=0.15)


def test_low_contrast_does_not_count_as_blur(scene):
    faint = (scene.picture().astype(float) * 0.4 + 60).astype(np.uint8)

    assert edge_width_px(to_grey(faint)) == pytest.approx(edge_width_px(to_grey(scene.picture())), rel=0.2)


@pytest.mark.skipif(not PHOTOGRAPHS, reason="shared/data/chessboard is absent")
def test_real_photographs_pass_and_their_blurred_copies_do_not():
    for path in PHOTOGRAPHS:
        photograph = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
        assert fault_of(photograph, BOUNDS) is None, path.name
        assert "blurred" in str(fault_of(cv2.GaussianBlur(photograph, (0, 0), 3.0), BOUNDS)), path.name
