"""Scoring: how an answer is judged against the truth, and that outcomes are kept on disk."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from armtwin.models.arm import nominal_arm
from armtwin.models.errors import InputError
from armtwin.scenarios.cli import main
from armtwin.scenarios.scoring.geometry import true_geometry
from armtwin.scenarios.scoring.judge import judge
from armtwin.scenarios.scoring.orders import SealOptions
from armtwin.scenarios.scoring.outcome import outcome_path
from armtwin.scenarios.scoring.scoring import score
from armtwin.scenarios.scoring.sealing import seal, world_folder
from armtwin.scenarios.scoring.summary import Rate, rates


def hidden(effect: str, joint: int | None = None, marker: str | None = None, **parameters: Any) -> dict[str, Any]:
    return {"effect": effect, "joint": joint, "marker": marker, "parameters": parameters, "moved_noises": 5.0}


def truth(*effects: dict[str, Any], kind: str = "single") -> dict[str, Any]:
    return {"kind": kind, "effects": list(effects), "noise_px": 0.1, "n_poses": 100}


def cause(
    effect: str, joint: int | None = None, *ties: tuple[str, int | None], **values: tuple[float, float]
) -> dict[str, Any]:
    return {
        "effect": effect,
        "joint": joint,
        "marker": None,
        "parameters": {name: {"value": v, "std": s} for name, (v, s) in values.items()},
        "equivalents": [{"effect": name, "joint": j, "marker": None} for name, j in ties],
        "explained_percent": 90.0,
    }


def said(verdict: str, *causes: dict[str, Any], gauge: tuple[str, ...] = ()) -> dict[str, Any]:
    return {
        "verdict": verdict,
        "causes": list(causes),
        "gauge": list(gauge),
        "seconds": 1.0,
        "noise": 0.1,
        "held_out": {"after_rms_mm": 0.11, "after_median_mm": 0.08, "noise_floor_mm": 0.1},
    }


def test_the_right_cause_at_the_right_joint_is_right() -> None:
    answer = judge(truth(hidden("backlash", 2)), said("named", cause("backlash", 2)))
    assert (answer.right, answer.site_right, answer.wrong) == (True, 1, False)


def test_the_right_cause_at_another_joint_is_right_but_for_its_place() -> None:
    answer = judge(truth(hidden("backlash", 2)), said("named", cause("backlash", 1)))
    assert (answer.right, answer.site_right, answer.sited) == (True, 0, 1)


def test_another_cause_is_wrong() -> None:
    answer = judge(truth(hidden("backlash", 2)), said("named", cause("hysteresis", 2)))
    assert (answer.right, answer.wrong) == (False, True)


def test_a_tie_that_holds_the_cause_is_right() -> None:
    answer = judge(truth(hidden("backlash", 2)), said("ambiguous", cause("hysteresis", 2, ("backlash", 2))))
    assert (answer.right, answer.site_right, answer.tied) == (True, 1, 2)


def test_a_tie_of_more_than_three_names_nothing() -> None:
    ties = (("backlash", 2), ("dead_band", 2), ("settling_lag", None))
    answer = judge(truth(hidden("backlash", 2)), said("ambiguous", cause("hysteresis", 2, *ties)))
    assert not answer.right


def test_a_further_cause_that_is_not_there_spoils_the_answer() -> None:
    answer = judge(truth(hidden("backlash", 2)), said("named", cause("backlash", 2), cause("outliers")))
    assert (answer.right, answer.wrong) == (False, True)


def test_saying_unknown_of_a_known_cause_is_not_right_but_not_wrong_either() -> None:
    answer = judge(truth(hidden("backlash", 2)), said("unknown"))
    assert (answer.right, answer.wrong) == (False, False)


def test_both_of_two_have_to_be_named() -> None:
    two = truth(hidden("backlash", 2), hidden("camera_moved"), kind="pair")
    one_named = judge(two, said("named", cause("backlash", 2)))
    assert (one_named.found, one_named.right) == (1, False)
    assert judge(two, said("named", cause("backlash", 2), cause("camera_moved"))).right


def test_any_word_about_a_world_without_a_fault_is_a_false_alarm() -> None:
    assert not judge(truth(kind="null"), said("none")).alarmed
    assert judge(truth(kind="null"), said("unknown")).alarmed
    assert judge(truth(kind="null"), said("named", cause("outliers"))).alarmed


def test_only_unknown_is_right_for_what_no_catalogue_has() -> None:
    strange = truth(hidden("cable"), kind="uncatalogued")
    assert judge(strange, said("unknown")).right
    assert judge(strange, said("named", cause("gravity_sag"))).wrong


def test_what_the_geometry_takes_up_has_to_stand_in_the_gauge() -> None:
    offset = truth(hidden("plane_offset", offset_mm=5.0))
    assert judge(offset, said("none", gauge=("plane_offset: scales all lengths",))).right
    assert not judge(offset, said("none")).right


def test_an_interval_is_two_standard_deviations_to_either_side() -> None:
    real = truth(hidden("servo_gain", 1, gain=1.10))
    assert judge(real, said("named", cause("servo_gain", 1, gain=(1.08, 0.011)))).covered == {"servo_gain.gain": True}
    assert judge(real, said("named", cause("servo_gain", 1, gain=(1.08, 0.009)))).covered == {"servo_gain.gain": False}


def test_intervals_count_only_where_the_place_is_right() -> None:
    assert (
        judge(truth(hidden("servo_gain", 1, gain=1.1)), said("named", cause("servo_gain", 2, gain=(1, 1)))).covered
        == {}
    )


def test_a_parameter_of_the_estimator_alone_has_no_truth_to_miss() -> None:
    answer = cause("camera_drift", settling=(3.0, 0.1))
    answer["parameters"]["settling"]["off"] = None
    assert judge(truth(hidden("camera_drift")), said("named", answer)).misses == {}


def test_the_held_out_error_is_measured_against_the_true_noise() -> None:
    real = truth(hidden("backlash", 2))
    answer = judge(real | {"noise_px": 0.2}, said("named", cause("backlash", 2)))
    assert answer.held_out_ratio is not None
    assert answer.held_out_ratio[0] == pytest.approx(0.55)


def test_rates_count_what_they_say() -> None:
    answers = [
        judge(truth(hidden("backlash", 2)), said("named", cause("backlash", 1))),
        judge(truth(hidden("backlash", 2)), said("named", cause("hysteresis", 2))),
        judge(truth(kind="null"), said("none")),
    ]
    found = rates(answers)
    assert (found["right"].hits, found["right"].total) == (1, 2)
    assert (found["site"].hits, found["site"].total) == (0, 1)
    assert (found["wrong"].hits, found["wrong"].total) == (1, 2)
    assert (found["false_alarms"].hits, found["false_alarms"].total) == (0, 1)
    assert found["unknown"].share is None


def test_a_target_is_met_between_its_bounds() -> None:
    assert Rate("", 95, 100, least=0.92, most=0.98).met
    assert not Rate("", 99, 100, least=0.92, most=0.98).met
    assert Rate("", 0, 0, least=0.9).met is None


def test_the_turn_of_the_last_links_corner_is_part_of_the_third_zero() -> None:
    arm = nominal_arm()
    bent = {
        "link_lengths_mm": [120.0, 121.7, 6.73, 38.0],  # l4 and l5 exchanged: turned by a quarter less twice the drawn
        "joint_offsets_rad": [0.0, 0.0, 0.0],
        "base_in_board_mm": [0.0, 0.0, 0.0],
    }
    found = true_geometry(arm, bent)
    assert found["l45_mm"] == pytest.approx((38.0**2 + 6.73**2) ** 0.5)
    assert found["theta3_zero_rad"] == pytest.approx(-1.2203, abs=1e-3)


@pytest.fixture(scope="module")
def sealed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("scored") / "set"
    list(seal(out, SealOptions(n=2, seed=4, effects=("none", "servo_gain")), jobs=1))
    return out


def test_a_set_is_scored_from_the_command_line(sealed: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as left:
        main(["score", str(sealed), "--jobs", "1"])
    assert left.value.code == 0
    table = json.loads((sealed / "score.json").read_text())
    assert table["worlds"] == 2
    assert table["confusion"]["nothing"] == {"none": 1}
    assert "right cause" in capsys.readouterr().out


def test_outcomes_are_kept_until_the_recording_changes(sealed: Path) -> None:
    score(sealed, 1)
    kept = outcome_path(sealed, 0), outcome_path(sealed, 1)
    before = [path.stat().st_mtime_ns for path in kept]
    samples = world_folder(sealed, 1) / "samples.csv"
    samples.write_text(samples.read_text() + "\n")
    score(sealed, 1)
    after = [path.stat().st_mtime_ns for path in kept]
    assert after[0] == before[0]
    assert after[1] > before[1]


def test_a_folder_without_sealed_worlds_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="armtwin seal"):
        score(tmp_path, 1)
