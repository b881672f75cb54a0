"""Single samples put right."""

from __future__ import annotations

import numpy as np

from armtwin.calib.diagnosis.diagnosis import diagnose
from tests.support.recordings import recording


def test_swapped_markers_are_exchanged_and_named_with_their_frames() -> None:
    def swap(pixels: np.ndarray) -> np.ndarray:
        out = pixels.copy()
        for row in (7, 40):
            out[row, 1], out[row, 2] = pixels[row, 2], pixels[row, 1]
        return out

    diagnosis = diagnose(recording(shift_px=swap))
    assert diagnosis.verdict == "named"
    (cause,) = diagnosis.causes
    assert (cause.active.effect.name, cause.active.site.marker) == ("marker_swap", "b")
    assert list(cause.active.values[1:]) == [7, 40]


def test_a_swapped_marker_is_exchanged_with_one_that_was_not_seen() -> None:
    def swap(pixels: np.ndarray) -> np.ndarray:
        out = pixels.copy()
        for row in (7, 40, 55):
            out[row, 1], out[row, 2] = pixels[row, 2], pixels[row, 1]
        out[40, 1] = np.nan
        return out

    (cause,) = diagnose(recording(shift_px=swap)).causes
    assert cause.active.effect.name == "marker_swap"
    assert list(cause.active.values[1:]) == [7, 40, 55]


def test_gross_errors_are_refused_named_and_do_not_bend_the_geometry() -> None:
    rng = np.random.default_rng(1)

    def spoil(pixels: np.ndarray) -> np.ndarray:
        out = pixels.copy()
        for row in (5, 33, 60, 71):
            out[row, rng.integers(4)] += rng.normal(0.0, 30.0, 2)
        return out

    clean, dirty = diagnose(recording()), diagnose(recording(shift_px=spoil))
    assert [cause.active.effect.name for cause in dirty.causes] == ["outliers"]
    assert set(dirty.causes[0].active.values[::2]) == {5, 33, 60, 71}
    assert np.abs(dirty.geometry.values - clean.geometry.values).max() < 0.05


def test_missed_poses_are_named_by_their_rows() -> None:
    def miss(q: np.ndarray) -> np.ndarray:
        out = q.copy()
        for row in (12, 50):
            out[row] = out[row - 1]
        return out

    (cause,) = diagnose(recording(miss)).causes
    assert cause.active.effect.name == "missed_command"
    assert list(cause.active.values) == [12, 50]


def test_a_rare_jump_of_one_joint_is_not_taken_for_gross_errors() -> None:
    def stick(q: np.ndarray) -> np.ndarray:
        out, held = q.copy(), q[0, 2]
        for row, angle in enumerate(q[:, 2]):
            held = angle if abs(angle - held) >= 0.03 else held
            out[row, 2] = held
        return out

    names = [cause.active.effect.name for cause in diagnose(recording(stick)).causes]
    assert names == ["dead_band"]
