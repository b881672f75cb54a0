"""What injectors take: declared beside them, checked and completed before anything is built."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from armtwin.models.arm import Arm, nominal_arm
from armtwin.models.catalogue.injection import (
    Injected,
    Stated,
    checked,
    other_marker,
    sample,
    samples,
    shifted_samples,
    switch,
)
from armtwin.models.catalogue.registry import Site, catalogue, effect_named
from armtwin.models.errors import InputError
from tests.support.contexts import context_of
from tests.support.worlds import errors_rad, upright_world, with_effect

ARM = nominal_arm()
# A parameter of every kind.
TAKEN = (
    Injected("width_rad", (0.0, 1.0)),
    Injected("give{joint}_rad", (0.0, 0.5), 0.1),
    Injected("friction_nm", (0.0, 2.0), optional=True),
    switch("loose", 0),
    sample("from_sample", 0),
    samples("samples"),
    other_marker("other"),
)
GIVEN: dict[str, Any] = {"width_rad": 0.2, "samples": [3, 5], "other": "b"}
# What a term says of a recording, and no bench has by itself.
OF_THE_RECORDING = {
    ("backlash", "start_side"),
    ("hysteresis", "start_side"),
    ("settling_lag", "until_next_command"),
}
# The same thing in other numbers: see their tests.
OTHERWISE_STATED = {"backlash", "gravity_sag", "servo_nonlinearity", "joint_slip", "settling_lag", "thermal_drift"}


def complete(parameters: dict[str, Any], arm: Arm = ARM, n_poses: int | None = 10) -> dict[str, Any]:
    return checked("play", "joint", TAKEN, Stated(parameters, Site(joint=1), at="effect 1: "), arm, n_poses)


def refusal(parameters: dict[str, Any]) -> str:
    with pytest.raises(InputError) as refused:
        complete(parameters)
    return str(refused.value)


def test_what_is_not_given_takes_its_default_and_what_is_optional_stays_out() -> None:
    defaults = {"give1_rad": 0.1, "give2_rad": 0.1, "give3_rad": 0.1, "loose": 0.0, "from_sample": 0}
    assert complete(GIVEN) == GIVEN | defaults


def test_a_parameter_of_each_joint_is_there_for_each_joint_of_the_arm() -> None:
    elbow = Arm("elbow", np.array([80.0]), np.zeros(2))
    assert "give2_rad" not in complete(GIVEN | {"other": elbow.known_markers[0]}, elbow)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"widht_rad": 0.1}, "effect 1: unknown key 'widht_rad'; did you mean 'width_rad'?"),
        ({"give4_rad": 0.1}, "effect 1: unknown key 'give4_rad'; did you mean 'give"),
        ({"jiont": 2}, "effect 1: unknown key 'jiont'; did you mean 'joint'?"),
        ({"width_rad": 50}, "effect 1: width_rad: found 50, a number from 0 to 1 is wanted"),
        ({"width_rad": 10**400}, "effect 1: width_rad: found 1000"),
        ({"width_rad": float("nan")}, "effect 1: width_rad: found nan, a number from 0 to 1 is wanted"),
        ({"width_rad": True}, "effect 1: width_rad: found True"),
        ({"width_rad": "0.1"}, "effect 1: width_rad: found '0.1'"),
        ({"width_rad": None}, "effect 1: width_rad: found None"),
        ({"loose": 0.5}, "effect 1: loose: found 0.5, a whole number from 0 to 1 is wanted"),
        ({"from_sample": 10}, "effect 1: from_sample: found 10, a sample's number from 0 to 9 is wanted"),
        ({"from_sample": -1}, "effect 1: from_sample: found -1"),
        ({"from_sample": 2.5}, "effect 1: from_sample: found 2.5"),
        ({"samples": [3, 10]}, "effect 1: samples: found [3, 10], a list of samples' numbers from 0 to 9 is wanted"),
        ({"samples": 3}, "effect 1: samples: found 3, a list"),
        ({"samples": [3, "4"]}, "effect 1: samples: found [3, '4']"),
        ({"other": "q"}, "effect 1: other: found 'q', one of the markers a, b, c, e, f is wanted"),
        ({"other": ["b"]}, "effect 1: other: found ['b']"),
    ],
)
def test_what_is_not_possible_is_named_with_what_is(change: dict[str, Any], said: str) -> None:
    assert refusal(GIVEN | change).startswith(said)


def test_what_has_to_be_given_and_is_not_is_named() -> None:
    without = {name: value for name, value in GIVEN.items() if name != "width_rad"}
    assert refusal(without) == "effect 1: key 'width_rad' is missing: a number from 0 to 1 is wanted"


def test_whole_numbers_may_be_written_with_a_decimal_point() -> None:
    assert complete(GIVEN | {"from_sample": 9.0, "samples": (1.0, 2)})["from_sample"] == 9.0


def test_without_a_recording_any_sample_is_possible() -> None:
    assert complete(GIVEN | {"from_sample": 5000}, n_poses=None)["from_sample"] == 5000


@pytest.mark.parametrize(
    ("where", "joint", "marker", "said"),
    [
        ("joint", None, None, "key 'joint' is missing: play sits at a joint, a number from 1 to 3 is wanted"),
        ("link", 7, None, "joint: found 7, a number from 1 to 3 is wanted"),
        ("joint", 1, "a", "marker: found 'a', play sits at no marker: remove this key"),
        ("marker", None, "q", "marker: found 'q', one of a, b, c, e, f is wanted"),
        ("marker", None, None, "key 'marker' is missing: play sits at a marker, one of a, b, c, e, f is wanted"),
        ("arm", 2, None, "joint: found 2, play sits at no joint: remove this key"),
        ("camera", None, "a", "marker: found 'a', play sits at no marker: remove this key"),
    ],
)
def test_an_effect_sits_where_its_kind_sits(where: Any, joint: Any, marker: Any, said: str) -> None:
    with pytest.raises(InputError) as refused:
        checked("play", where, (), Stated({}, Site(joint, marker)), ARM)
    assert str(refused.value) == said


def test_in_a_later_recording_what_was_to_happen_has_happened() -> None:
    parameters = {"width_rad": 0.2, "from_sample": 12, "samples": [3, 10, 14]}
    assert shifted_samples(TAKEN, parameters, ARM, 10) == {"width_rad": 0.2, "from_sample": 2, "samples": [0, 4]}
    assert shifted_samples(TAKEN, parameters, ARM, 20) == {"width_rad": 0.2, "from_sample": 0, "samples": []}


@pytest.mark.parametrize("name", sorted(catalogue()))
def test_every_value_that_can_be_found_can_be_built_in(name: str) -> None:
    """The extended twin must be built from whatever a fit ends at, its bounds included."""
    effect, context = effect_named(name), context_of()
    for site in effect.sites(context):
        bounds = np.array([parameter.bounds for parameter in effect.parameters(context, site)]).reshape(-1, 2)
        if effect.found is None:
            for values in bounds.T:
                with_effect(upright_world(), name, effect.built(context, site, values), site.joint, site.marker)


@pytest.mark.parametrize("name", sorted(set(catalogue()) - OTHERWISE_STATED))
def test_an_injector_takes_every_parameter_of_its_term_but_those_of_the_recording(name: str) -> None:
    effect, context = effect_named(name), context_of()
    site = effect.sites(context)[0]
    parameters = effect.parameters(context, site)
    values = np.array([parameter.bounds[1] for parameter in parameters])
    if effect.found is None:
        left_out = {(name, p.name) for p in parameters} - {(name, key) for key in effect.built(context, site, values)}
        assert left_out == {(of, key) for of, key in OF_THE_RECORDING if of == name}


@pytest.mark.parametrize("end", [0, 1])
@pytest.mark.parametrize("name", ["backlash", "hysteresis", "gravity_sag", "link_bending", "payload", "settling_lag"])
def test_the_simulated_arm_stands_at_the_ends_of_what_is_possible(name: str, end: int) -> None:
    effect = effect_named(name)
    numbers = {one.name.format(joint=1): one.bounds[end] for one in effect.injected if one.kind == "number"}
    if name == "hysteresis":
        numbers["length_rad"] = max(numbers["length_rad"], 2.5 * numbers["lag_rad"])
    world = with_effect(upright_world(), name, numbers, joint=1 if effect.where in ("joint", "link") else None)
    assert np.isfinite(errors_rad(world, np.array([[0.1, 0.1, 0.1], [-0.1, 0.2, 0.0]]))).all()


def test_the_side_of_a_gap_at_its_first_pose_is_no_part_of_a_bench() -> None:
    assert effect_named("backlash").built(context_of(), Site(joint=2), np.array([0.02, 1.0, 0.0, 0.25, 0.0])) == {
        "width_rad": 0.02,
        "gravity_loaded": 0.0,
    }
