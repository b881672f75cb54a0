"""Named causes beside what is true of the bench."""

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from armtwin.models.camera_files import nominal_camera
from armtwin.scenarios.runner.named import beside_truth, left_by_calibration


def cause(effect: str, joint: int | None = None, ties: tuple[str, ...] = (), **values: float) -> dict[str, Any]:
    return {
        "effect": effect,
        "joint": joint,
        "marker": None,
        "label": effect,
        "explained_percent": 50.0,
        "equivalents": [{"effect": name, "joint": None, "marker": None, "label": name} for name in ties],
        "parameters": [
            {"name": name, "value": value, "std": 0.1, "interval95": [0.0, 1.0], "unstated": 0.0}
            for name, value in values.items()
        ],
    }


def injected(effect: str, joint: int | None = None, **values: float) -> dict[str, Any]:
    return {"effect": effect, "joint": joint, "marker": None, "parameters": values}


def test_an_estimate_stands_beside_the_value_that_was_injected() -> None:
    (row,) = beside_truth([cause("backlash", 2, width_rad=0.03)], [injected("backlash", 2, width_rad=0.031)], [])
    assert row["origin"] == "injected"
    assert (row["parameters"][0]["value"], row["parameters"][0]["truth"]) == (0.03, 0.031)


def test_the_right_effect_at_the_wrong_joint_is_not_what_was_injected() -> None:
    found, missed = beside_truth([cause("backlash", 1, width_rad=0.03)], [injected("backlash", 2, width_rad=0.03)], [])
    assert found["origin"] is None
    assert found["parameters"][0]["truth"] is None
    assert (missed["label"], missed["joint"], missed["parameters"][0]["value"]) == (None, 2, None)


def test_a_parameter_that_the_scenario_leaves_out_is_off() -> None:
    (row,) = beside_truth([cause("gravity_sag", c1=0.1, c2=0.01)], [injected("gravity_sag", c1=0.12)], [])
    assert [parameter["truth"] for parameter in row["parameters"]] == [0.12, 0.0]


def test_an_effect_that_ties_with_the_named_one_is_not_listed_as_missed() -> None:
    rows = beside_truth([cause("gravity_sag", ties=("payload",), c1=0.1)], [injected("payload", mass_kg=0.1)], [])
    assert [row["origin"] for row in rows] == ["injected"]
    assert rows[0]["parameters"][0]["truth"] is None


def test_a_camera_that_its_calibration_left_tilted_is_told_apart_from_an_injected_tilt() -> None:
    left = [injected("camera_tilt", tilt_x_rad=0.0004)]
    (row,) = beside_truth([cause("camera_tilt", tilt_x_rad=0.0006)], [], left)
    assert row["origin"] == "calibration"
    assert row["parameters"][0]["truth"] == 0.0004
    assert beside_truth([], [], left) == []


def test_the_tilt_that_a_calibration_left_turns_the_assumed_camera_into_the_true_one() -> None:
    true = nominal_camera()
    turn = Rotation.from_rotvec([2e-4, -3e-4, 0.0]).as_matrix()
    assumed = true.moved(turn.T, np.zeros(3))
    tilt = next(effect for effect in left_by_calibration(assumed, true) if effect["effect"] == "camera_tilt")
    assert tilt["parameters"]["tilt_x_rad"] == pytest.approx(2e-4, abs=1e-9)
    assert tilt["parameters"]["tilt_y_rad"] == pytest.approx(-3e-4, abs=1e-9)
