"""Every effect at every site: which are looked for, and which comes out first."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from armtwin.calib.diagnosis.candidates import candidate_sites, candidates, fit_without
from armtwin.models.catalogue.registry import Site, effect_named
from tests.support.diagnoses import data_of, fitted, geometry_of
from tests.support.recordings import gain_of, recording

GAINS = [(effect_named(name), Site(joint=joint)) for name in ("servo_gain", "backlash") for joint in (1, 2, 3)]


def test_the_cause_that_was_put_in_comes_first_at_its_joint_with_its_size() -> None:
    data = data_of(recording(gain_of(2, 1.03)))
    first = candidates(data, geometry_of(data), GAINS)[0]
    assert first.active.key == ("servo_gain", 2, None)
    assert abs(first.active.values[0] - 1.03) < 1e-3


def test_what_the_model_has_already_is_not_looked_for_again() -> None:
    data = data_of(recording(gain_of(2, 1.03)))
    model = fitted(data, "servo_gain", Site(joint=2), 1.0)
    looked_for = [(effect.name, site.joint) for effect, site in candidate_sites(data, model.effects)]
    assert ("servo_gain", 2) not in looked_for
    assert ("servo_gain", 1) in looked_for


def test_what_only_pictures_show_is_not_looked_for_in_measured_angles() -> None:
    seen = recording()
    angles = replace(seen, markers_px={}, camera=None, q_meas=seen.q_cmd, pixel_noise_px=None)
    data = replace(data_of(seen), problem=data_of(replace(angles, pixel_noise_px=1.0)).problem)
    assert not {effect.name for effect, _ in candidate_sites(data)} & {"camera_tilt", "marker_offset", "focal_length"}


def test_where_no_joint_turns_back_nothing_is_looked_for_that_needs_it() -> None:
    one_way = {"ramp": np.linspace([-0.4, -0.3, -0.4], [0.4, 0.3, 0.4], 60)}
    needing = {effect.name for effect, _ in candidate_sites(data_of(recording(paths=one_way))) if effect.needs_return}
    assert not needing


def test_a_model_without_one_of_its_effects_is_fitted_anew() -> None:
    data = data_of(recording(gain_of(2, 1.03)))
    model = fitted(data, "servo_gain", Site(joint=2), 1.0)
    without = fit_without(data, model, model.effects[0])
    assert without.effects == ()
    np.testing.assert_allclose(without.deviance, geometry_of(data).deviance, rtol=1e-3)
