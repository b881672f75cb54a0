"""The stickers as they are printed, against the detector that measures them."""

import shutil
import subprocess
from pathlib import Path

import cv2
import numpy as np
import pytest

from armtwin.calib.markers import detect
from armtwin.hardware.targets import RED, targets_pdf

DPI = 300
PX_PER_MM = 3.0  # the paper's picture: 42 px for a disc of 14 mm
ROWS_PX = 820  # the sheet's first two rows: a picture holds no more than 24 discs


@pytest.fixture
def sheet(tmp_path: Path) -> np.ndarray:
    if shutil.which("pdftoppm") is None:
        pytest.skip("pdftoppm (poppler-utils) is not installed")
    (tmp_path / "targets.pdf").write_bytes(targets_pdf("a4"))
    command = ["pdftoppm", "-r", str(DPI), "-f", "2", "-l", "2", "-png", "targets.pdf", "page"]
    subprocess.run(command, cwd=tmp_path, check=True)
    return cv2.imread(str(next(tmp_path.glob("page*.png"))))[:ROWS_PX]


def without_crosses(sheet: np.ndarray) -> np.ndarray:
    """The same discs, plain red."""
    plain = sheet.copy()
    red = tuple(255 * part for part in RED.rgb()[::-1])
    for disc in detect(filmed(sheet)):
        middle = (disc.centre + 0.5) * DPI / 25.4 / PX_PER_MM - 0.5
        cv2.circle(plain, np.rint(middle).astype(int).tolist(), 30, red, cv2.FILLED)  # 2.5 mm; the rim is at 7 mm
    return plain


def filmed(sheet: np.ndarray) -> np.ndarray:
    size = np.rint(np.array(sheet.shape[1::-1]) * PX_PER_MM * 25.4 / DPI).astype(int)
    small = cv2.resize(sheet, size.tolist(), interpolation=cv2.INTER_AREA)
    noise = np.random.default_rng(1).normal(0.0, 1.0, small.shape)
    return np.clip(cv2.GaussianBlur(small, (0, 0), 0.7) * 0.75 + 10 + noise, 0, 255).astype(np.uint8)


def test_the_cross_that_a_pin_is_pricked_through_moves_no_centre(sheet: np.ndarray):
    marked, plain = detect(filmed(sheet)), detect(filmed(without_crosses(sheet)))

    assert len(marked) == len(plain) == 16
    shifts = [min(np.linalg.norm(disc.centre - other.centre) for other in plain) for disc in marked]
    assert max(shifts) < 0.01  # px, a sixth of what a webcam's noise does
