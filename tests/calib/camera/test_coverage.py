"""Coverage says how much of the image was seen, and which parts were not."""

import numpy as np
import pytest

from armtwin.calib.camera.coverage import REGIONS, cover


def grid(x0: float, x1: float, y0: float, y1: float, n: int = 40) -> np.ndarray:
    x, y = np.meshgrid(np.linspace(x0, x1, n), np.linspace(y0, y1, n))
    return np.stack([x.ravel(), y.ravel()], axis=1)


def test_corners_all_over_leave_nothing_empty():
    coverage = cover(grid(0, 639, 0, 479), (640, 480))
    assert coverage.empty_regions == ()
    assert coverage.cell_share == 1.0
    assert coverage.hull_share == pytest.approx(1.0, abs=0.01)
    assert coverage.reach_share == pytest.approx(1.0, abs=0.01)
    assert coverage.counts.sum() == 1600


def test_a_quarter_of_the_picture_is_a_quarter_of_its_hull():
    coverage = cover(grid(0, 319, 0, 239), (640, 480))
    assert coverage.hull_share == pytest.approx(0.25, abs=0.002)
    assert coverage.cell_share == 0.25
    assert set(coverage.empty_regions) == {"top right", "right", "bottom left", "bottom", "bottom right"}


@pytest.mark.parametrize(("row", "column"), [(r, c) for r in range(3) for c in range(3)])
def test_the_region_without_corners_is_named(row, column):
    pixels = grid(0, 899, 0, 599, 90)
    u, v = pixels.T
    inside = (u // 300 == column) & (v // 200 == row)
    assert cover(pixels[~inside], (900, 600)).empty_regions == (REGIONS[row][column],)


def test_corners_at_the_very_edge_are_counted():
    assert cover(np.array([[-0.5, -0.5], [639.5, 479.5], [3.0, 400.0]]), (640, 480)).counts.sum() == 3
