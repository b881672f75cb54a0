"""The loader reads OpenCV's matrices and bare exponents, and builds no object."""

import pytest
import yaml

from armtwin.models.yaml_loader import CameraLoader


def load(text: str):
    return yaml.load(text, Loader=CameraLoader)


def test_an_opencv_matrix_is_a_mapping():
    text = "m: !!opencv-matrix\n   rows: 1\n   cols: 2\n   dt: d\n   data: [ 1., -2.5e-01 ]\n"
    assert load(text) == {"m": {"rows": 1, "cols": 2, "dt": "d", "data": [1.0, -0.25]}}


@pytest.mark.parametrize("text", ["1e-05", "-1E5", "+2e+3", "1.e4", "1.5e7"])
def test_an_exponent_makes_a_float(text):
    assert load(text) == float(text)


def test_integers_and_words_stay_what_they_are():
    assert load("[12, e5, 1e, image]") == [12, "e5", "1e", "image"]


@pytest.mark.parametrize("tag", ["!!python/object/apply:os.getcwd []", "!!python/name:os.getcwd", "!!python/tuple [1]"])
def test_no_python_object_is_built(tag):
    with pytest.raises(yaml.YAMLError):
        load(f"x: {tag}")
