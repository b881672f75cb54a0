"""Many photographs are searched two at a time; what takes too long is left behind."""

import threading
import time

import cv2
import numpy as np
import pytest

from armtwin.calib.camera.corners import Corners
from armtwin.models.errors import InputError
from armtwin.scenarios.camera_calibration.search import search


@pytest.fixture
def photographs(tmp_path):
    paths = [tmp_path / f"{i}.png" for i in range(4)]
    for path in paths:
        cv2.imwrite(str(path), np.zeros((30, 40), np.uint8))
    return [(path.name, path) for path in paths]


def test_all_are_searched_in_their_order_and_their_size_is_told(photographs):
    found = list(search(photographs, lambda name, image: Corners(name, np.zeros((1, 2)))))
    assert [one.name for one in found] == ["0.png", "1.png", "2.png", "3.png"]
    assert {one.size for one in found} == {(40, 30)}
    assert all(one.view is not None and not one.late for one in found)


def test_a_search_that_takes_too_long_is_given_up_and_the_others_go_on(photographs):
    forever = threading.Event()

    def find(name, image):
        if name == "1.png":
            forever.wait()
        return Corners(name, np.zeros((1, 2)))

    begun = time.monotonic()
    found = list(search(photographs, find, limit_s=0.3))
    forever.set()
    assert time.monotonic() - begun < 5.0
    assert [one.late for one in found] == [False, True, False, False]
    assert found[1].view is None


def test_a_photograph_that_cannot_be_read_ends_the_search(photographs, tmp_path):
    (tmp_path / "2.png").write_bytes(b"no picture")
    with pytest.raises(InputError, match=r"2\.png: found no image"):
        list(search(photographs, lambda name, image: None))
