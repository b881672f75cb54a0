"""Faults are named in whatever form a part gives them: recordings of a bench that shares nothing with armtwin."""

from __future__ import annotations

from pathlib import Path

import pytest

from armtwin.calib.diagnosis.diagnosis import Diagnosis, diagnose
from armtwin.models.recordings.reader import read_recording
from tests.support.real_forms import FORMS, Expected, write_recording

# What stands for its kind in the everyday run; the others, and pairs, are run with the slow tests.
QUICK = ("nothing", "whole_degrees_trimmed", "lag_constant_speed", "missed_single_joint", "slips_and_back")
SLOW = tuple(name for name in FORMS if name not in QUICK)
PAIRS = (
    "microseconds+slips_and_back",
    "truncated_counts+plain_gain",
    "whole_degrees_trimmed+dead_band_edge",
)


def answered(folder: Path, forms: str, seed: int) -> tuple[Expected, Diagnosis]:
    expected = write_recording(folder, tuple(forms.split("+")), seed)
    return expected, diagnose(read_recording(folder))


def missing_and_wrong(expected: Expected, found: Diagnosis) -> tuple[list[str], list[str]]:
    """What should have been named and was not, and what was named (no tie with it) and should not have been."""
    groups = [[cause.active, *cause.equivalents] for cause in found.causes]
    missing = []
    for name, joint in expected.causes:
        names = {name, *expected.allowed}
        places = {joint, None}
        if not any(a.effect.name in names and (joint is None or a.site.joint in places) for g in groups for a in g):
            missing.append(f"{name} {joint}")
    right = {name for name, _ in expected.causes} | set(expected.allowed)
    wrong = [g[0].label for g in groups if not right & {a.effect.name for a in g}]
    return missing, wrong


@pytest.mark.parametrize("form", QUICK)
def test_a_fault_is_named_in_the_form_that_a_real_part_gives_it(form: str, tmp_path: Path) -> None:
    assert missing_and_wrong(*answered(tmp_path, form, seed=1)) == ([], [])


@pytest.mark.slow
@pytest.mark.parametrize("form", [*SLOW, *PAIRS])
def test_so_are_the_other_forms_and_two_at_once(form: str, tmp_path: Path) -> None:
    assert missing_and_wrong(*answered(tmp_path, form, seed=2)) == ([], [])


@pytest.mark.slow
@pytest.mark.parametrize("seed", [3, 4])
@pytest.mark.parametrize("form", ["potentiometer", "play_soft", "spring_stiffening"])
def test_a_form_that_bends_smoothly_is_named_alone(form: str, seed: int, tmp_path: Path) -> None:
    assert missing_and_wrong(*answered(tmp_path, form, seed)) == ([], [])
