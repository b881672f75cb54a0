import json
from pathlib import Path

import numpy as np
import pytest

from armtwin.models.catalogue.motion_effect import motion_catalogue
from armtwin.models.errors import InputError
from armtwin.sim.sealed_motion.draw import draw_log
from armtwin.sim.sealed_motion.forms import FORMS
from armtwin.sim.sealed_motion.plans import SHAPES, draw_motions
from armtwin.sim.sealed_motion.strange import STRANGE
from armtwin.sim.sealed_motion.writing import write_log

ROWS = 600


def test_every_effect_of_a_moving_arm_is_hidden_and_at_least_five_that_no_catalogue_has() -> None:
    assert set(FORMS) == set(motion_catalogue())
    assert len(STRANGE) >= 5
    assert not set(STRANGE) & set(motion_catalogue())


@pytest.mark.parametrize("seed", range(5))
def test_motions_follow_one_another_at_20_to_200_hz(seed: int) -> None:
    motions, held_out = draw_motions(np.random.default_rng(seed), 3, 3000)
    time_s = np.concatenate([motion.time_s for motion in motions])
    assert (np.diff(time_s) > 0).all()
    assert 2 <= len(motions) <= 8
    assert set(held_out) < {motion.name for motion in motions}
    for motion in motions:
        assert 1 / 250 < np.median(np.diff(motion.time_s)) < 1 / 18
        assert motion.name.rsplit("_", 1)[0] in SHAPES
        assert np.ptp(motion.q_cmd, axis=0).min() > 0.02


@pytest.mark.parametrize("name", ["friction", "backlash", "payload", "crosstalk"])
def test_what_is_hidden_shows_above_the_noise(name: str) -> None:
    log = draw_log(np.random.default_rng(5), (name,), n_rows=ROWS)
    (hidden,) = log.truth["effects"]
    assert hidden["effect"] == name
    assert hidden["moved_noises"] >= 5.0
    assert np.isfinite(log.q_meas).all()


def test_four_effects_sit_where_they_are_not_taken_for_one_another() -> None:
    log = draw_log(np.random.default_rng(2), ("friction", "backlash", "latency", "servo_lag"), n_rows=ROWS)
    places = {effect["effect"]: effect["joint"] for effect in log.truth["effects"]}
    assert places["friction"] != places["backlash"]
    assert places["latency"] != places["servo_lag"]


def test_a_log_is_written_as_a_moving_recording_without_the_truth(tmp_path: Path) -> None:
    log = draw_log(np.random.default_rng(1), ("thermal_drift",), n_rows=ROWS)
    write_log(tmp_path, log)
    header = json.loads((tmp_path / "recording.json").read_text())
    assert (header["schema"], header["motion"]) == ("armtwin.recording/1", "moving")
    lines = (tmp_path / "samples.csv").read_text().splitlines()
    assert len(lines) == len(log.q_meas) + 1
    assert lines[0].startswith("sample,time_s,trajectory,theta1_cmd_rad")
    assert not any("drift" in path.read_text() for path in tmp_path.iterdir())


def test_an_effect_that_cannot_be_hidden_is_refused_with_the_nearest_name() -> None:
    with pytest.raises(InputError, match="'frction' can be hidden in a moving arm; did you mean 'friction'"):
        draw_log(np.random.default_rng(0), ("frction",))
