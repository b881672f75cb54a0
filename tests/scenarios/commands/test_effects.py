"""`armtwin effects`: every effect with what the code says of it."""

from __future__ import annotations

import json

import pytest

from armtwin.models.catalogue.registry import catalogue
from armtwin.scenarios.cli import main


def said(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    with pytest.raises(SystemExit) as left:
        main(["effects", *arguments])
    out, err = capsys.readouterr()
    assert left.value.code == 0, err
    return out


def test_the_list_as_json_holds_every_effect_with_bounded_parameters(capsys: pytest.CaptureFixture[str]) -> None:
    listed = json.loads(said(["--json"], capsys))
    assert [effect["effect"] for effect in listed] == sorted(catalogue())
    for effect in listed:
        assert effect["summary"]
        assert effect["experiment"]
        assert all(low < high for low, high in (one["bounds"] for one in effect["parameters"]))


def test_one_effect_is_shown_with_its_units_and_what_it_is_taken_for(capsys: pytest.CaptureFixture[str]) -> None:
    text = said(["backlash"], capsys)
    assert "width_rad" in text
    assert "taken for: hysteresis" in text
    assert "told apart by: fine steps" in text


def test_an_effect_of_single_samples_says_what_a_scenario_states_of_it(capsys: pytest.CaptureFixture[str]) -> None:
    text = " ".join(said(["marker_swap"], capsys).split())
    assert "in a scenario or a twin: other, a marker; samples, a list of samples" in text


def test_the_page_has_a_heading_for_every_effect(capsys: pytest.CaptureFixture[str]) -> None:
    page = said(["--markdown"], capsys)
    assert [line[3:] for line in page.splitlines() if line.startswith("## ")] == sorted(catalogue())
    assert "| `width_rad` | rad | 0 |" in page


def test_a_misspelt_effect_is_answered_with_the_nearest(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as left:
        main(["effects", "backlsh"])
    assert left.value.code == 2
    assert "did you mean 'backlash'?" in capsys.readouterr().err
