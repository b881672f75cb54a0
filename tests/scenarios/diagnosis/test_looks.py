"""An unknown cause is described: when it comes, what it follows, where it sits."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from armtwin.calib.diagnosis.diagnosis import Diagnosis, diagnose
from armtwin.calib.diagnosis.structure import Trend
from armtwin.models.recordings.reader import read_recording
from armtwin.scenarios.diagnosis.checks import notes_on
from armtwin.scenarios.diagnosis.looks import looks_like, remainder_in_words
from tests.support.real_forms import write_recording


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory) -> Diagnosis:
    folder = tmp_path_factory.mktemp("sound")
    write_recording(folder, ("nothing",), seed=1, n=60)
    return diagnose(read_recording(folder))


def leaving(found: Diagnosis, added: np.ndarray, against: str) -> Diagnosis:
    """The same diagnosis with so much more left of every point (N, M, 2), px."""
    final = found.explanation.final
    residual = final.residual + added
    misfit = np.where(found.explanation.data.counts, (residual**2).sum(axis=-1) / found.explanation.data.noise**2, 0.0)
    explanation = replace(found.explanation, final=replace(final, residual=residual, misfit=misfit))
    return replace(found, explanation=explanation, trends_after=(Trend(against, 0.5, 0.0),), verdict="unknown")


def test_what_jumps_is_said_to_jump_and_at_which_sample(sound: Diagnosis) -> None:
    n, m = sound.explanation.data.counts.shape
    jump = np.zeros((n, m, 2))
    jump[30:] = 5.0
    assert looks_like(leaving(sound, jump, "order"), np.arange(100, 100 + n))[0] == "jumps at sample 130"


def test_what_grows_is_said_to_grow(sound: Diagnosis) -> None:
    n, m = sound.explanation.data.counts.shape
    ramp = np.linspace(0.0, 10.0, n)[:, None, None] * np.ones((n, m, 2))
    assert looks_like(leaving(sound, ramp, "time"), np.arange(n))[0] == "grows with time"


def test_the_joint_whose_direction_it_follows_is_named(sound: Diagnosis) -> None:
    q = sound.problem.context.q_cmd
    side = np.sign(np.diff(q[:, 1], prepend=q[0, 1]))[:, None, None] * np.ones(
        (*sound.explanation.data.counts.shape, 2)
    )
    words = looks_like(leaving(sound, 3.0 * side, "direction of approach"), np.arange(len(q)))
    assert words[0] == "follows the direction from which joint 2 came"


def test_the_part_of_the_picture_where_it_sits_is_named(sound: Diagnosis) -> None:
    seen = sound.explanation.data.problem.observed
    ninth = (3.0 * seen / np.array([1280, 720])).astype(int)
    there = (ninth == [1, 0]).all(axis=-1)
    assert 0 < there.sum() < there.size / 2
    words = looks_like(leaving(sound, there[..., None] * np.full(2, 50.0), "image position"), np.arange(len(seen)))
    assert "sits in the upper middle of the picture" in words


def test_a_marker_that_is_gone_from_one_pose_on_is_never_called_nothing(tmp_path: Path) -> None:
    write_recording(tmp_path, ("nothing",), seed=1, n=60)
    recording = read_recording(tmp_path)
    tip = recording.markers_px["f"].copy()
    tip[40:] = np.nan
    found = diagnose(replace(recording, markers_px={**recording.markers_px, "f": tip}))
    assert found.verdict == "unknown"
    assert "marker F, which is never seen from pose 40 on" in remainder_in_words(found, recording.sample)
    note = notes_on(replace(recording, markers_px={**recording.markers_px, "f": tip}))[-1]
    assert note.startswith("marker F was seen in 40 of 60 poses and not in 20, and never from sample 40 on")
