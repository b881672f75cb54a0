import json

import numpy as np
import pytest

from armtwin.models.catalogue.registry import catalogue
from armtwin.models.errors import InputError
from armtwin.models.recordings.reader import read_recording
from armtwin.models.recordings.writer import write_recording
from armtwin.sim.sealed import STRENGTHS, draw_world, sealed_effects


def test_every_effect_of_the_catalogue_can_be_hidden() -> None:
    assert set(sealed_effects()) == set(catalogue())


@pytest.mark.parametrize("effect", sealed_effects())
def test_the_truth_names_the_hidden_effect_and_how_far_it_moves_the_markers(effect: str) -> None:
    sealed = draw_world(np.random.default_rng(11), effect, "medium", n_poses=60)
    (hidden,) = sealed.truth["effects"]
    assert hidden["effect"] == effect
    assert hidden["moved_noises"] >= STRENGTHS["medium"][0]
    json.dumps(sealed.truth)


def test_a_stronger_effect_moves_the_markers_farther() -> None:
    moved = [
        draw_world(np.random.default_rng(2), "servo_gain", strength, n_poses=60).truth["effects"][0]["moved_noises"]
        for strength in ("weak", "medium", "strong")
    ]
    assert moved == sorted(moved)
    for noises, (low, high) in zip(moved, STRENGTHS.values(), strict=True):
        assert low <= noises <= 1.3 * high


def test_null_worlds_differ_from_the_drawing_in_their_geometry_only() -> None:
    sealed = draw_world(np.random.default_rng(5), None, n_poses=60)
    assert sealed.truth["effects"] == []
    assert not sealed.world.mechanics
    assert not sealed.world.electronics
    nominal = sealed.recording.arm.link_lengths_mm
    assert np.abs(np.array(sealed.truth["link_lengths_mm"]) - nominal).max() > 0.1


def test_two_effects_are_hidden_at_once() -> None:
    sealed = draw_world(np.random.default_rng(6), ("backlash", "camera_moved"), n_poses=60)
    assert [hidden["effect"] for hidden in sealed.truth["effects"]] == ["backlash", "camera_moved"]


def test_the_same_seed_gives_the_same_world() -> None:
    one, two = (draw_world(np.random.default_rng(7), "joint_slip", n_poses=60) for _ in range(2))
    assert one.truth == two.truth
    for name, points in one.recording.markers_px.items():
        np.testing.assert_array_equal(points, two.recording.markers_px[name])


def test_weight_shows_only_where_gravity_pulls() -> None:
    for seed in range(4):
        sealed = draw_world(np.random.default_rng(seed), "payload", n_poses=60)
        assert np.linalg.norm(sealed.recording.arm.gravity_m_s2) > 9.0


def test_options_override_what_is_drawn() -> None:
    sealed = draw_world(np.random.default_rng(8), "servo_gain", n_poses=40, noise_px=0.5, markers=("f",), missing=0.2)
    assert set(sealed.recording.markers_px) == {"f"}
    assert sealed.truth["noise_px"] == 0.5
    assert len(sealed.recording) < 60
    assert np.isnan(sealed.recording.markers_px["f"]).any()


def test_an_unknown_effect_is_refused_with_the_nearest() -> None:
    with pytest.raises(InputError, match="unknown effect 'backlahs'; did you mean 'backlash'"):
        draw_world(np.random.default_rng(0), "backlahs")


def test_a_sealed_recording_survives_its_folder(tmp_path) -> None:  # type: ignore[no-untyped-def]
    sealed = draw_world(np.random.default_rng(9), "hysteresis", n_poses=40)
    write_recording(tmp_path / "sealed", sealed.recording)
    back = read_recording(tmp_path / "sealed")
    np.testing.assert_allclose(back.q_cmd, sealed.recording.q_cmd)
    assert back.held_out == sealed.recording.held_out
