"""Sizes are read from the PDF's own drawing operators, and the board is found in a raster of the page."""

import re
import shutil
import subprocess
from pathlib import Path

import cv2
import numpy as np
import pytest

from armtwin.hardware.targets import targets_pdf
from armtwin.models.errors import InputError

MM = 25.4 / 72.0
SHEETS = {"a4": (297.0, 210.0), "letter": (279.4, 215.9)}
NUMBER = rb"(-?[\d.]+)"


def streams(pdf: bytes) -> list[bytes]:
    return re.findall(rb"stream\r?\n(.*?)endstream", pdf, re.DOTALL)


def rectangles_mm(stream: bytes) -> np.ndarray:
    """(N, 4) left, bottom, width, height."""
    return np.array(re.findall(rb" ".join([NUMBER] * 4) + rb" re", stream), dtype=float) * MM


@pytest.fixture(params=sorted(SHEETS))
def paper(request: pytest.FixtureRequest) -> str:
    return request.param


def test_sheet_has_the_papers_size(paper: str):
    boxes = re.findall(rb"/MediaBox \[ 0 0 " + NUMBER + rb" " + NUMBER + rb" \]", targets_pdf(paper))

    assert len(boxes) == 3
    for box in boxes:
        np.testing.assert_allclose(np.array(box, dtype=float) * MM, SHEETS[paper], atol=0.01)


def test_board_has_squares_of_23_mm_and_lies_on_the_sheet(paper: str):
    squares = rectangles_mm(streams(targets_pdf(paper))[0])

    assert len(squares) == 35
    np.testing.assert_allclose(squares[:, 2:], 23.0, atol=0.001)
    low, high = squares[:, :2].min(axis=0), (squares[:, :2] + squares[:, 2:]).max(axis=0)
    np.testing.assert_allclose(high - low, [230.0, 161.0], atol=0.002)
    assert (low > 10.0).all()  # printers leave 3 to 6 mm at the edges
    assert (np.array(SHEETS[paper]) - high > 10.0).all()


def test_rulers_have_a_tick_a_millimetre(paper: str):
    for stream, length in zip(streams(targets_pdf(paper)), [100, 100, 200], strict=True):
        lines = re.findall(rb" ".join([NUMBER] * 2) + rb" m " + rb" ".join([NUMBER] * 2) + rb" l", stream)
        ends = np.array(lines, dtype=float) * MM
        scale = next(line for line in ends if line[1] == line[3] and abs(line[2] - line[0] - length) < 0.01)
        ticks = np.sort(ends[(ends[:, 0] == ends[:, 2]) & (ends[:, 1] == scale[1])][:, 0])
        np.testing.assert_allclose(ticks, scale[0] + np.arange(length + 1), atol=0.002)


def test_printers_are_asked_not_to_scale():
    assert b"/PrintScaling /None" in targets_pdf()


def test_unknown_paper_is_refused():
    with pytest.raises(InputError, match=r"'a5'.*a4"):
        targets_pdf("a5")


def test_a_papers_name_of_thousands_of_characters_is_cut():
    with pytest.raises(InputError) as error:
        targets_pdf("k" * 5000)
    assert len(str(error.value)) < 200


@pytest.fixture
def pages(paper: str, tmp_path: Path) -> list[np.ndarray]:
    """Pages at 150 dots an inch."""
    if shutil.which("pdftoppm") is None:
        pytest.skip("pdftoppm (poppler-utils) is not installed")
    (tmp_path / "targets.pdf").write_bytes(targets_pdf(paper))
    subprocess.run(["pdftoppm", "-r", "150", "-png", "targets.pdf", "page"], cwd=tmp_path, check=True)
    return [cv2.imread(str(path)) for path in sorted(tmp_path.glob("page*.png"))]


def test_printed_board_is_found_with_its_corners_in_place(pages: list[np.ndarray]):
    grey = cv2.cvtColor(pages[0], cv2.COLOR_BGR2GRAY)

    found, corners = cv2.findChessboardCornersSB(grey, (9, 6))

    assert found
    grid = corners.reshape(6, 9, 2) / 150.0 * 25.4
    pixel = 25.4 / 150.0  # the rasteriser puts edges on whole pixels
    np.testing.assert_allclose(np.linalg.norm(grid[:, -1] - grid[:, 0], axis=-1), 8 * 23.0, atol=pixel)
    np.testing.assert_allclose(np.linalg.norm(grid[-1] - grid[0], axis=-1), 5 * 23.0, atol=pixel)


def test_printed_stickers_have_discs_of_14_mm_on_21_mm(pages: list[np.ndarray]):
    blue, _, red = cv2.split(pages[1])
    for mask, diameter in ((red > 150) & (blue < 100), 14.0), (blue < 100, 21.0):
        count, _, stats, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8))
        big = stats[1:][stats[1:, cv2.CC_STAT_AREA] > 2000]
        assert len(big) == 32, count
        sides = np.sqrt(big[:, cv2.CC_STAT_AREA] * 4 / np.pi) / 150.0 * 25.4
        np.testing.assert_allclose(sides, diameter, atol=0.15)  # the cross in the middle takes a little


def test_a_cross_marks_the_middle_of_every_disc_and_stays_on_the_sticker_that_is_cut_out(pages: list[np.ndarray]):
    blue, _, red = cv2.split(pages[1])
    count, grounds, stats, middles = cv2.connectedComponentsWithStats((cv2.blur(blue, (9, 9)) < 128).astype(np.uint8))
    assert count == 1 + 32 + np.sum(stats[1:, cv2.CC_STAT_AREA] < 2000)
    for number in np.flatnonzero(stats[:, cv2.CC_STAT_AREA] >= 2000)[1:]:
        white = np.argwhere((grounds == number) & (blue > 60) & (red > 200))[:, ::-1]
        near = white[np.linalg.norm(white - middles[number], axis=1) < 30]  # 5 mm; the disc's rim is at 7 mm
        assert len(near) > 10
        np.testing.assert_allclose(near.mean(axis=0), middles[number], atol=1.0)
        assert np.ptp(near, axis=0).max() < 24  # 4 mm
