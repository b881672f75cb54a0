"""Photographs are found by file, folder and pattern; what is no whole photograph is refused."""

import os
import struct
import zlib

import cv2
import numpy as np
import pytest
from PIL import Image

from armtwin.calib.camera.images import MAX_PIXELS, check_size, find_images, read_gray
from armtwin.models.errors import InputError


@pytest.fixture
def folder(tmp_path):
    rng = np.random.default_rng(0)
    for name in ("b.png", "a.jpg", "c.png"):
        cv2.imwrite(str(tmp_path / name), rng.integers(0, 255, (60, 80), dtype=np.uint8))
    (tmp_path / "notes.txt").write_text("no image")
    return tmp_path


def test_a_folder_stands_for_its_images_by_name(folder):
    assert [path.name for path in find_images([folder]).images] == ["a.jpg", "b.png", "c.png"]


def test_files_and_patterns_keep_their_order_and_count_once(folder):
    found = find_images([folder / "c.png", folder / "*.png", folder]).images
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


def test_images_of_two_sizes_are_refused_by_name_and_size():
    with pytest.raises(InputError, match=r"d\.png: found 81x60 px, wanted 80x60 px as a\.jpg"):
        check_size("d.png", (81, 60), (80, 60), "a.jpg")


def test_a_picture_that_a_program_turned_is_told_as_that():
    with pytest.raises(InputError, match="turned by a program, take the original"):
        check_size("d.png", (60, 80), (80, 60), "a.jpg")


def test_a_folder_says_what_it_passed_over_and_finds_videos(folder):
    (folder / "IMG_1.HEIC").write_bytes(b"\x00\x00\x00\x18ftypheic")
    (folder / "turn.mp4").write_bytes(b"")
    found = find_images([folder])
    assert [path.name for path in found.videos] == ["turn.mp4"]
    reasons = " ".join(reason for _, reason in found.passed_over)
    assert "notes.txt is no photograph" in reasons
    assert "IMG_1.HEIC is a HEIC photograph: convert it to JPEG" in reasons


def test_a_folder_of_heic_alone_says_to_convert_them(tmp_path):
    (tmp_path / "IMG_1.HEIC").write_bytes(b"\x00\x00\x00\x18ftypheic")
    with pytest.raises(InputError, match="found 1 HEIC photographs and no other, wanted JPEG or PNG"):
        find_images([tmp_path])


def test_a_heic_photograph_is_named_whatever_its_suffix(tmp_path):
    (tmp_path / "a.jpg").write_bytes(b"\x00\x00\x00\x18ftypheic" + b"\x00" * 100)
    with pytest.raises(InputError, match=r"a\.jpg: found a HEIC photograph, wanted JPEG or PNG"):
        read_gray(tmp_path / "a.jpg")


def test_how_the_camera_was_held_does_not_turn_the_picture(tmp_path):
    gray = np.arange(60 * 80, dtype=np.uint8).reshape(60, 80)
    for orientation in (1, 6):
        exif = Image.Exif()
        exif[0x0112] = orientation
        Image.fromarray(gray).save(tmp_path / f"{orientation}.jpg", exif=exif, quality=95)
    upright, sideways = (read_gray(tmp_path / f"{orientation}.jpg") for orientation in (1, 6))
    np.testing.assert_array_equal(sideways, upright)
    assert sideways.shape == (60, 80)


def test_a_picture_too_large_is_refused_before_it_is_decoded(tmp_path):
    width, height = 30000, 20000
    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    chunks = [(b"IHDR", head), (b"IDAT", zlib.compress(b"\x00" * 1000)), (b"IEND", b"")]
    raw = b"\x89PNG\r\n\x1a\n"
    for kind, data in chunks:
        raw += struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    (tmp_path / "huge.png").write_bytes(raw)
    assert width * height > MAX_PIXELS
    with pytest.raises(InputError, match="found 600 megapixels, wanted a photograph of at most 120"):
        read_gray(tmp_path / "huge.png")


def test_a_pipe_is_no_photograph(tmp_path):
    os.mkfifo(tmp_path / "pipe.png")
    for read in (read_gray, lambda path: find_images([path])):
        with pytest.raises(InputError, match="no plain file"):
            read(tmp_path / "pipe.png")


def test_a_photograph_comes_as_grey_levels(folder):
    image = read_gray(folder / "b.png")
    assert image.shape == (60, 80)
    assert image.dtype == np.uint8
