"""Every lab runs as it is handed out, its solution passes every check, and each check finds a mistake."""

from __future__ import annotations

import importlib
import importlib.util
from typing import Any

import marimo
import pytest

from armtwin.scenarios.labs.check import Check
from armtwin.scenarios.labs.shelf import LABS, Lab

LAB = pytest.mark.parametrize("lab", LABS, ids=lambda lab: f"lab-{lab.number}")


@LAB
def test_the_notebook_runs_as_it_is_handed_out_and_nothing_is_answered_yet(lab: Lab) -> None:
    checks = checks_of(lab, {})
    assert len(checks) >= 3
    assert {check.state for check in checks} == {"open"}


@LAB
def test_its_solution_passes_every_check(lab: Lab) -> None:
    checks = checks_of(lab, solution(lab).SOLUTION)
    assert [check for check in checks if not check.passed] == []


@LAB
def test_each_check_finds_a_mistake_and_says_something_of_it(lab: Lab) -> None:
    wrong: dict[str, list[Any]] = solution(lab).WRONG
    assert set(wrong) == set(solution(lab).SOLUTION)
    for turn in range(max(len(mistakes) for mistakes in wrong.values())):
        checks = checks_of(lab, {name: mistakes[turn % len(mistakes)] for name, mistakes in wrong.items()})
        assert [check for check in checks if check.state != "wrong"] == []
        assert all(len(check.said) > 15 for check in checks)


def checks_of(lab: Lab, answers: dict[str, Any]) -> list[Check]:
    """Run a notebook with a student's answers in place of his cells and return its checks."""
    spec = importlib.util.spec_from_file_location(lab.stem, lab.notebook)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    app: marimo.App = module.app
    outputs, _ = app.run(defs=answers or None)
    return [output for output in outputs if isinstance(output, Check)]


def solution(lab: Lab) -> Any:
    return importlib.import_module(f"armtwin.scenarios.labs.instructor.lab_{lab.number}")
