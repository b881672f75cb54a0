"""The causes beside what the scenario states of them."""

from __future__ import annotations

import pytest

from armtwin.scenarios.report.diagnosis_section import stated


@pytest.mark.parametrize(
    ("truth", "shown"),
    [
        (0.0123456, "0.01235"),
        (-2, "−2"),
        ("b", "B"),
        ([3, 7], "3, 7"),
        (list(range(20)), "0, 1, 2, 3, 4, 5, 6, 7 …"),
    ],
)
def test_a_truth_is_shown_whatever_kind_of_parameter_it_is(truth: float | str | list[int], shown: str) -> None:
    assert stated(truth) == shown
