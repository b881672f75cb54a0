"""Scenario files: what is accepted, and what is said of what is not."""

import copy
import tomllib
from pathlib import Path
from typing import Any

import pytest

from armtwin.models.errors import InputError
from armtwin.scenarios.runner.world import build_world
from armtwin.scenarios.scenario import builtin_scenarios, check_scenario, read_scenario

SCENARIO = """
schema = "armtwin.scenario/1"
title = "a test"

[trajectories.circle]
kind = "circle"
radius_mm = 15

[trajectories.line]
kind = "line"
start_mm = [-145, 25]
end_mm = [-115, 45]

[[effects]]
name = "backlash"
joint = 2
width_rad = 0.01
"""


@pytest.fixture
def tables() -> dict[str, Any]:
    return tomllib.loads(SCENARIO)


@pytest.mark.parametrize("name", sorted(builtin_scenarios()))
def test_every_builtin_scenario_can_be_read_and_its_world_be_built(name: str) -> None:
    assert build_world(read_scenario(name)).compile().njnt >= 3


def test_the_scenarios_that_are_promised_are_there() -> None:
    promised = {"paper", "geometric", "noisy", "misfocused", "occluded", "bumped-camera"}
    assert promised <= set(builtin_scenarios())


def test_an_effects_parameters_stand_beside_its_name(tables: dict[str, Any]) -> None:
    effect = check_scenario(tables, "s.toml").effects[0]
    assert (effect.name, effect.joint, effect.parameters) == ("backlash", 2, {"width_rad": 0.01})


def test_all_trajectories_but_the_validations_are_calibrated_on(tables: dict[str, Any]) -> None:
    assert check_scenario(tables, "s.toml").calibrate_on == ("circle",)


def test_a_scenario_written_out_is_the_same_scenario(tables: dict[str, Any]) -> None:
    scenario = check_scenario(tables, "s.toml")
    again = check_scenario(scenario.model_dump(mode="json", by_alias=True), "s.json")
    assert again.fingerprint == scenario.fingerprint


@pytest.mark.parametrize("key", ["seed", "board_views", "title"])
def test_the_fingerprint_changes_with_what_the_results_depend_on(tables: dict[str, Any], key: str) -> None:
    other = copy.deepcopy(tables) | {key: {"seed": 1, "board_views": 7, "title": "other"}[key]}
    assert check_scenario(other, "s.toml").fingerprint != check_scenario(tables, "s.toml").fingerprint


def _without(tables: dict[str, Any], key: str) -> None:
    del tables[key]


def _instead(tables: dict[str, Any], name: str, **keys: object) -> None:
    """Put another effect in the place of the scenario's."""
    tables["effects"] = [{"name": name, **keys}]


BROKEN = [
    (lambda t: t.update(titel=t.pop("title")), "unknown key 'titel'; did you mean 'title'?"),
    (lambda t: t["trajectories"]["circle"].update(radius=9), "'trajectories.circle.radius'; did you mean 'radius_mm'?"),
    (lambda t: t.update(picture={"blur_px": 1}), "unknown key 'picture.blur_px'; did you mean 'blur_sigma_px'?"),
    (lambda t: t["trajectories"].pop("line"), "trajectories"),
    (lambda t: t.update(validate_on="lin"), "validate_on names trajectory 'lin', which is not declared"),
    (lambda t: t["trajectories"]["circle"].update(radius_mm=-3), "trajectories.circle.radius_mm"),
    (lambda t: t["trajectories"]["circle"].update(radius_mm="15"), "radius_mm: a number is wanted"),
    (lambda t: t.update(seed=True), "seed: a whole number is wanted, found True"),
    (lambda t: t["trajectories"]["circle"].update(samples=1), "trajectories.circle.samples"),
    (lambda t: t["trajectories"]["circle"].update(radius_mm=300), "trajectories.circle: pose 3"),
    (lambda t: t["effects"][0].update(name="backlsh"), "unknown effect 'backlsh'; did you mean 'backlash'?"),
    (lambda t: t["effects"][0].update(name="backlsh"), "effect 1: name: unknown effect"),
    (lambda t: t["effects"][0].update(width_rad="wide"), "effect 1: width_rad: found 'wide', a number from 0 to 1 is"),
    (lambda t: t["effects"][0].update(width_rad=50), "effect 1: width_rad: found 50, a number from 0 to 1 is wanted"),
    (lambda t: t["effects"][0].update(width_rad=float("nan")), "effect 1: width_rad: found nan"),
    (lambda t: t["effects"][0].update(width_rad=True), "effect 1: width_rad: found True"),
    (lambda t: t["effects"][0].update(widht_rad=0.1), "effect 1: unknown key 'widht_rad'; did you mean 'width_rad'?"),
    (lambda t: t["effects"][0].pop("width_rad"), "effect 1: key 'width_rad' is missing: a number from 0 to 1 is"),
    (lambda t: t["effects"][0].pop("joint"), "effect 1: key 'joint' is missing: backlash sits at a joint, a number"),
    (lambda t: t["effects"][0].update(joint=7), "effect 1: joint: found 7, a number from 1 to 3 is wanted"),
    (lambda t: t["effects"][0].update(marker="a"), "effect 1: marker: found 'a', backlash sits at no marker"),
    (lambda t: _instead(t, "marker_offset", marker="q", x_mm=1, y_mm=1), "marker: found 'q', one of a, b, c, e, f"),
    (lambda t: _instead(t, "servo_gain", joint=1, gain=-3), "effect 1: gain: found -3, a number from 0.1 to 3 is"),
    (
        lambda t: _instead(t, "gravity_sag"),
        "effect 1: gravity_sag gets none of its parameters compliance1_rad_per_nm",
    ),
    (lambda t: _instead(t, "gravity_sag", joint=1, compliance1_rad_per_nm=0.1), "gravity_sag sits at no joint"),
    (lambda t: _instead(t, "joint_slip", joint=1, jump_rad=0.1, from_sample=200), "a sample's number from 0 to 199 is"),
    (lambda t: _instead(t, "joint_slip", joint=1, jump_rad=0.1, from_sample=1.5), "effect 1: from_sample: found 1.5"),
    (
        lambda t: _instead(t, "missed_command", samples=[3, 200]),
        "effect 1: samples: found [3, 200], a list of samples'",
    ),
    (lambda t: _instead(t, "missed_command", samples=7), "effect 1: samples: found 7, a list of samples' numbers from"),
    (lambda t: _instead(t, "marker_swap", marker="b", other="b", samples=[3]), "effect 1: other: found 'b', which is"),
    (
        lambda t: _instead(t, "hysteresis", joint=1, lag_rad=0.1, length_rad=0.1),
        "effect 1: hysteresis: length_rad 0.1",
    ),
    (lambda t: t.update(board_views=2), "board_views"),
    (lambda t: t.update(schema="armtwin.scenario/9"), "schema"),
    (lambda t: _without(t, "schema"), "key 'schema' is missing"),
]


@pytest.mark.parametrize(("spoil", "said"), BROKEN)
def test_what_is_wrong_with_a_scenario_is_said_in_one_line(tables: dict[str, Any], spoil: Any, said: str) -> None:
    spoil(tables)
    with pytest.raises(InputError) as error:
        check_scenario(tables, "s.toml")
    assert "s.toml: " in str(error.value)
    assert said in str(error.value)
    assert "\n" not in str(error.value)


def test_an_unreachable_path_names_the_pose_and_the_reach(tables: dict[str, Any]) -> None:
    tables["trajectories"]["line"]["end_mm"] = [-400, 0]
    with pytest.raises(InputError, match=r"trajectories\.line: pose \d+ .* is out of reach: .* the arm reaches"):
        check_scenario(tables, "s.toml")


def test_an_effect_of_single_samples_may_name_every_pose_of_a_run(tables: dict[str, Any]) -> None:
    """Two trajectories of 50 poses, then the validation's twice more."""
    _instead(tables, "missed_command", samples=[0, 3, 199])
    assert build_world(check_scenario(tables, "s.toml")).electronics


def test_an_unknown_name_is_answered_with_the_nearest_one() -> None:
    with pytest.raises(InputError, match="did you mean 'paper'"):
        read_scenario("papr")


def test_a_file_that_is_no_toml_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "broken.toml"
    path.write_text("title = ")
    with pytest.raises(InputError, match=r"broken\.toml: not TOML"):
        read_scenario(str(path))


@pytest.mark.parametrize(
    ("table", "key", "value", "said"),
    [
        ("geometry", "length_errors_mm", [1e8, 0.0, 0.0, 0.0], "at most 1000 is wanted, found 100000000.0"),
        ("geometry", "joint_errors_rad", [100.0, 0.0, 0.0], "found 100.0"),
        (None, "gauge_lengths_mm", [1e6], "at most 1000 is wanted, found 1000000.0"),
    ],
)
def test_what_no_arm_on_a_table_has_is_refused_before_anything_is_built(
    tables: dict[str, Any], table: str | None, key: str, value: object, said: str
) -> None:
    spoilt = copy.deepcopy(tables)
    (spoilt if table is None else spoilt.setdefault(table, {}))[key] = value
    with pytest.raises(InputError, match=said) as error:
        check_scenario(spoilt, "s.toml")
    assert key in str(error.value)
