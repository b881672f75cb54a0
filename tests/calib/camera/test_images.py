"""Photographs are found by file, folder and pattern; what is no whole photograph is refused."""

import cv2
import numpy as np
import pytest

from armtwin.calib.camera.images import find_images, read_gray, read_views
from armtwin.models.errors import InputError


@pytest.fixture
def folder(tmp_path):
    rng = np.random.default_rng(0)
    for name in ("b.png", "a.jpg", "c.png"):
        cv2.imwrite(str(tmp_path / name), rng.integers(0, 255, (60, 80), dtype=np.uint8))
    (tmp_path / "notes.txt").write_text("no image")
    return tmp_path


def test_a_folder_stands_for_its_images_by_name(folder):
    assert [path.name for path in find_images([folder])] == ["a.jpg", "b.png", "c.png"]


def test_files_and_patterns_keep_their_order_and_count_once(folder):
    found = find_images([folder / "c.png", folder / "*.png", folder])
    assert [path.name for path in found] == ["c.png", "b.png", "a.jpg"]


@pytest.mark.parametrize("name", ["none.png", "*.bmp", "no/where/*.png"])
def test_what_names_nothing_is_refused(folder, name):
    with pytest.raises(InputError, match=r"found no image, wanted"):
        find_images([folder / name])


def test_an_empty_folder_is_refused(tmp_path):
    with pytest.raises(InputError, match="wanted a folder with images"):
        find_images([tmp_path])


@pytest.mark.parametrize("name", ["a.jpg", "b.png"])
def test_a_file_cut_short_is_refused(folder, name):
    path = folder / name
    path.write_bytes(path.read_bytes()[:-40])
    with pytest.raises(InputError, match=rf"{name}: found no image or a corrupt one"):
        read_gray(path)


def test_a_text_an_empty_and_a_missing_file_are_refused(folder):
    (folder / "empty.png").write_bytes(b"")
    for name in ("notes.txt", "empty.png", "missing.png"):
        with pytest.raises(InputError, match=name):
            read_gray(folder / name)


def test_images_of_two_sizes_are_refused_by_name_and_size(folder):
    cv2.imwrite(str(folder / "d.png"), np.zeros((60, 81), np.uint8))
    with pytest.raises(InputError, match=r"d\.png: found 81x60 px, wanted 80x60 px as a\.jpg"):
        read_views(find_images([folder]))


def test_a_photograph_comes_as_grey_levels(folder):
    image = read_gray(folder / "b.png")
    assert image.shape == (60, 80)
    assert image.dtype == np.uint8
