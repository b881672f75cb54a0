"""Sealed logs of moving arms: what a set holds, and how an answer is judged."""

import json
from collections import Counter
from pathlib import Path
from typing import Any

import pytest

from armtwin.scenarios.cli import main
from armtwin.scenarios.scoring.moving_orders import moving_orders
from armtwin.scenarios.scoring.moving_outcome import outcome_of_table
from armtwin.scenarios.scoring.moving_scoring import judge_log, moving_rates
from armtwin.scenarios.scoring.orders import SealOptions


def truth(*effects: tuple[str, int | None, dict[str, float]], kind: str = "single") -> dict[str, Any]:
    hidden = [
        {"effect": name, "joint": joint, "marker": None, "parameters": numbers, "moved_noises": 9.0}
        for name, joint, numbers in effects
    ]
    return {"kind": kind, "effects": hidden, "n_rows": 100, "noise_rad": [1e-3, 1e-3]}


def said(*causes: dict[str, Any], verdict: str = "named", after: float = 1e-3) -> dict[str, Any]:
    table = {
        "verdict": verdict,
        "causes": list(causes),
        "held_out": {"joints": [{"trajectory": "steps", "joint": 2, "after_rms_rad": after}]},
    }
    return {"seconds": 1.0, **outcome_of_table(table)}


def cause(effect: str, joint: int | None, *equivalents: str, **numbers: tuple[float, float]) -> dict[str, Any]:
    return {
        "effect": effect,
        "joint": joint,
        "parameters": {name: {"value": value, "std": std} for name, (value, std) in numbers.items()},
        "equivalents": [{"effect": name, "joint": joint} for name in equivalents],
    }


def ended(arguments: list[str]) -> object:
    with pytest.raises(SystemExit) as left:
        main(arguments)
    return left.value.code


HIDDEN = ("friction", 2, {"coulomb_rad": 0.010})


def test_a_set_of_240_holds_nulls_singles_pairs_fours_and_unknown_faults() -> None:
    orders = moving_orders(SealOptions(n=240, seed=1, moving=True))
    assert Counter(order.kind for order in orders) == {
        "null": 40,
        "single": 100,
        "pair": 36,
        "quad": 24,
        "uncatalogued": 40,
    }
    assert len({order.effects for order in orders if order.kind == "single"}) == 20
    assert len({order.effects for order in orders if order.kind == "uncatalogued"}) >= 5


def test_the_right_cause_at_its_joint_is_right_and_its_interval_counts() -> None:
    judged = judge_log(truth(HIDDEN), said(cause("friction", 2, coulomb_rad=(0.0101, 0.0001)), after=1.1e-3))
    assert judged.right
    assert judged.site_right == 1
    assert judged.covered == {"friction.coulomb_rad": True}
    assert judged.held_out_ratio == pytest.approx((1.1, 1.1))
    missed = judge_log(truth(HIDDEN), said(cause("friction", 2, coulomb_rad=(0.0101, 0.00002))))
    assert missed.covered == {"friction.coulomb_rad": False}


def test_a_tie_that_holds_it_is_right_and_another_name_is_wrong() -> None:
    assert judge_log(truth(HIDDEN), said(cause("backlash", 2, "friction"), verdict="ambiguous")).right
    wrong = judge_log(truth(HIDDEN), said(cause("backlash", 2)))
    assert wrong.wrong
    assert not wrong.right


def test_another_joint_is_not_its_site() -> None:
    assert judge_log(truth(HIDDEN), said(cause("friction", 1))).site_right == 0


def test_nothing_hidden_and_something_said_is_a_false_alarm() -> None:
    assert judge_log(truth(kind="null"), said(verdict="none")).right
    assert judge_log(truth(kind="null"), said(verdict="unknown")).alarmed


def test_what_no_catalogue_has_is_unknown() -> None:
    hum = truth(("hum", 1, {}), kind="uncatalogued")
    assert judge_log(hum, said(verdict="unknown")).right
    assert judge_log(hum, said(cause("friction", 1))).wrong


def test_the_rates_count_all_of_four_and_wrong_names_among_them() -> None:
    four = truth(HIDDEN, ("latency", None, {}), ("servo_gain", 1, {}), ("joint_slip", 1, {}), kind="quad")
    whole = [cause("friction", 2), cause("latency", None), cause("servo_gain", 1), cause("joint_slip", 1)]
    found = moving_rates([judge_log(four, said(*whole)), judge_log(four, said(*whole[:3], cause("payload", None)))])
    assert (found["four"].hits, found["four"].total) == (1, 2)
    assert (found["wrong"].hits, found["wrong"].total) == (1, 2)


def test_a_sealed_set_of_logs_is_made_alike_again_and_keeps_its_truth_aside(tmp_path: Path) -> None:
    for name in ("first", "again"):
        options = ["--n", "2", "--seed", "4", "--effects", "latency,none", "--jobs", "1"]
        assert ended(["seal", "--moving", *options, "--out", str(tmp_path / name)]) == 0
    logs = [(tmp_path / name / "worlds" / "0001" / "samples.csv").read_bytes() for name in ("first", "again")]
    assert logs[0] == logs[1]
    worlds = json.loads((tmp_path / "first" / "truth.json").read_text())["worlds"]
    assert sorted(world["kind"] for world in worlds.values()) == ["null", "single"]


def test_options_of_settled_sets_are_refused_for_logs(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert ended(["seal", "--moving", "--pairs", "--out", str(tmp_path / "out")]) == 2
    assert "--moving" in capsys.readouterr().err
