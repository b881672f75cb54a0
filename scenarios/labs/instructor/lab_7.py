"""Lab 7: the sealed robot.

**Goals.** The student plans an experiment on a budget, argues from residuals to a cause, states a size with an honest
interval, and uses what he found: the tip follows a line that the drawing's commands miss.

**Before.** Labs 4 to 6. Make a class (`armtwin lab make`) and serve it (`armtwin serve --class`); the notebook
practises without.

**Time.** 90 minutes with practice; the graded robot as homework over a week or two.

**Tools.** With `tools = ["calibrate", "diagnose"]` in CLASS.toml the choice of experiments, the interval and the
argument are what is graded. With `tools = []` the page's buttons are gone; a student who has installed armtwin can
still call `armtwin.diagnose` at home, so say in class what you expect to see in the argument.

**Where they get stuck.** *The plan*: poses in random order show play as noise; let every joint turn back several
times. *The interval*: `diagnose` gives a standard deviation; twice that, if the model is right. *The parameter's
name*: `armtwin effects NAME` lists them.

**The question.** Held-out poses, repeats from the other side, another load: a wrong model that fits the fitted poses
misses those. The corrected line would then be off most where the poses of the line differ most from those that were
fitted.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.diagnosis.diagnosis import Diagnosis, diagnose
from armtwin.models.trajectories import LINE_END_MM, LINE_START_MM, line
from armtwin.models.wanted_path import WantedPath
from armtwin.scenarios.diagnosis.findings import twin_of
from armtwin.scenarios.labs.material.sealed import measure
from armtwin.scenarios.twins.correction import correct

Array = NDArray[np.float64]

_ROBOT, _POINTS = 7, 20


def poses(n: int = 54) -> Array:
    """Turn every joint to and fro, at rates that never meet."""
    turn = np.linspace(0.0, 2.0 * np.pi, n)
    return np.stack([0.35 * np.sin(3 * turn), 0.2 + 0.3 * np.sin(4 * turn + 1), -0.3 + 0.4 * np.sin(5 * turn)], axis=-1)


@cache
def found() -> Diagnosis:
    """Ask the tool."""
    return diagnose(measure(_ROBOT, poses()), lambda _: None)


def answer() -> dict[str, Any]:
    """State cause, place and size: three standard deviations and a hundredth, since no term is quite the arm's form."""
    effect, std = twin_of(found()).effects[0], float(found().causes[0].std[0])
    name, value = next((key, float(one)) for key, one in effect.parameters.items() if one)
    reach = 3 * std + 0.01 * abs(value)
    named = {"cause": effect.effect, "joint": effect.joint, "parameter": name}
    return {**named, "value": value, "low": value - reach, "high": value + reach}


def line_commands() -> Array:
    """Correct the line for the twin that was found."""
    wanted = line(LINE_START_MM, LINE_END_MM, _POINTS)
    names, places = np.full(_POINTS, "line"), tuple(f"pose {row}" for row in range(_POINTS))
    path = WantedPath(names, np.zeros(_POINTS), places, tip_mm=wanted[:, :2], theta_rad=wanted[:, 2])
    return correct(twin_of(found()), path).plan.q_cmd


SOLUTION: dict[str, Any] = {
    "my_poses": poses(),
    "answer": answer(),
    "line_commands": line_commands(),
}
WRONG: dict[str, list[Any]] = {
    "my_poses": [np.zeros((20, 3)), poses(80), "random"],
    "answer": [{"cause": "none"}, {"cause": "backlash", "value": 1.0}, {**answer(), "cause": "poltergeist"}],
    "line_commands": [np.zeros((20, 3)), np.full((20, 3), np.nan)],
}
