"""The gain on poses that no step of the search has seen, and which poses those are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from armtwin.calib.diagnosis.holdout import held_out_gain, held_out_rows, held_out_trend, in_millimetres
from armtwin.models.catalogue.registry import Site
from armtwin.models.errors import RecordingError
from armtwin.models.recordings.recording import Recording
from tests.support.diagnoses import data_of, explanation_of, fitted, geometry_of
from tests.support.recordings import gain_of, recording, waves


def test_the_trajectories_that_a_recording_names_are_held_out() -> None:
    rows, names, _ = held_out_rows(recording(held_out=("wave_1",)))
    assert names == ("wave_1",)
    assert np.flatnonzero(rows).tolist() == list(range(30, 60))


def test_a_recording_that_names_none_holds_out_its_last_or_every_fourth_pose() -> None:
    rows, names, _ = held_out_rows(recording(held_out=()))
    assert names == ("wave_3",)
    rows, names, _ = held_out_rows(recording(held_out=(), paths=waves(2)))
    assert names == ()
    assert np.flatnonzero(rows)[:3].tolist() == [2, 6, 10]


def test_of_few_poses_none_is_kept_back() -> None:
    rows, _, words = held_out_rows(recording(held_out=(), paths=waves(2, 9)))
    assert not rows.any()
    assert "every pose in turn" in words


def test_a_recording_that_holds_out_all_is_refused() -> None:
    with pytest.raises(RecordingError, match=r"held_out names every trajectory .*; leave some to fit to"):
        held_out_rows(recording(paths=waves(2), held_out=("wave_0", "wave_1")))


def gain(seen: Recording, effect: bool):  # type: ignore[no-untyped-def]
    rows, names, words = held_out_rows(seen)
    data = data_of(seen, ~rows)
    final = fitted(data, "servo_gain", Site(joint=2), 1.0) if effect else geometry_of(data)
    return held_out_gain(data_of(seen).problem, explanation_of(data, final), rows, names, words)


def test_the_right_cause_brings_the_held_out_error_down_to_the_noise() -> None:
    held = gain(recording(gain_of(2, 1.03)), effect=True)
    assert held.n_poses == 30
    assert held.nominal_rms_mm > held.before_rms_mm > 3.0 * held.after_rms_mm
    assert held.after_rms_mm == pytest.approx(held.noise_floor_mm, rel=0.25)
    assert held.gain_ci95_percent[0] < held.gain_percent < held.gain_ci95_percent[1]
    assert held.bears_out


def test_a_cause_that_is_not_there_bears_out_nothing() -> None:
    held = gain(recording(), effect=True)
    assert not held.bears_out


def test_what_only_the_held_out_poses_show_is_a_trend_of_theirs() -> None:
    def late(pixels: np.ndarray) -> np.ndarray:
        out = pixels.copy()
        out[90:] += 1.5 * np.sin(np.arange(30))[:, None, None]
        return out

    for seen, shows in ((recording(shift_px=late), True), (recording(), False)):
        rows, _, _ = held_out_rows(seen)
        data = data_of(seen, ~rows)
        trend = held_out_trend(data_of(seen).problem, explanation_of(data, geometry_of(data)), rows)
        assert (trend is not None) == shows


def test_a_residual_in_millimetres_is_the_way_in_the_plane() -> None:
    seen = recording(noise_px=1e-6)
    moved = replace(seen, markers_px={name: px + np.array([1.0, 0.0]) for name, px in seen.markers_px.items()})
    problem = data_of(seen).problem
    residual = data_of(moved).problem.observed - problem.observed
    plane = in_millimetres(problem, problem.nominal, residual)
    by_x, by_y = problem.pixels_by_plane(problem.nominal)
    np.testing.assert_allclose(by_x * plane[..., :1] + by_y * plane[..., 1:], residual, atol=1e-9)
