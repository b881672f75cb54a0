"""Inverse kinematics of the extended twin."""

from __future__ import annotations

import numpy as np
import pytest

from armtwin.models.catalogue.context import Context
from armtwin.models.catalogue.correct import corrected_commands
from armtwin.models.catalogue.predict import Active, joint_angles
from armtwin.models.catalogue.registry import Site, effect_named
from armtwin.models.errors import UnreachablePoseError
from armtwin.models.kinematics import Deviation, forward
from armtwin.models.trajectories import paper_trajectories
from tests.support.contexts import active, context_of

BUILT = Deviation(np.array([3.0, -2.0, 0.5, 0.1]), np.array([0.02, -0.03, 0.05]))
LINE = paper_trajectories()["line"]


def reached(history: Context, q_cmd: np.ndarray, effects: list[Active]) -> np.ndarray:
    from dataclasses import replace

    n = len(q_cmd)
    whole = replace(
        history,
        q_cmd=np.concatenate([history.q_cmd, q_cmd]),
        time_s=None,
        trajectory=np.concatenate([history.trajectory, np.full(n, "line")]),
        payload_kg=np.zeros(len(history) + n),
    )
    return forward(history.arm, joint_angles(whole, effects)[len(history) :], BUILT)


@pytest.mark.parametrize(
    "effects",
    [
        [],
        [active("backlash", [0.016, -1.0, 0.0], joint=2)],
        [active("backlash", [0.014, -1.0, 0.0], joint=1), active("gravity_sag", [0.1, 0.06, 0.05])],
        [active("hysteresis", [0.01, 0.06, 0.0], joint=2)],
        [active("servo_nonlinearity", [0.005, 0.006, 14.0], joint=3)],
    ],
    ids=["geometry", "play", "play and sag", "friction", "gear"],
)
def test_the_corrected_commands_bring_the_tip_to_the_line(effects: list[Active]) -> None:
    history = context_of(timed=False)
    correction = corrected_commands(history, BUILT, effects, LINE)
    error = reached(history, correction.q_cmd, effects)[:, :2] - LINE[:, :2]
    assert np.abs(error).max() < 1e-4


def test_play_is_taken_up_from_the_side_of_approach() -> None:
    history = context_of(timed=False)
    play = [active("backlash", [0.02, -1.0, 0.0], joint=2)]
    plain = corrected_commands(history, BUILT, [], LINE).q_cmd
    corrected = corrected_commands(history, BUILT, play, LINE).q_cmd
    rising = np.diff(plain[:, 1], prepend=history.q_cmd[-1, 1]) > 0
    np.testing.assert_allclose((corrected - plain)[:, 1], np.where(rising, 0.01, -0.01), atol=1e-9)


def test_what_a_dead_band_swallows_is_said() -> None:
    stuck = [Active(effect_named("dead_band"), Site(joint=2), np.array([0.05, 0.0]))]
    assert corrected_commands(context_of(timed=False), BUILT, stuck, LINE).missed_rad.max() > 1e-3


def test_a_pose_out_of_reach_is_refused() -> None:
    with pytest.raises(UnreachablePoseError):
        corrected_commands(context_of(), BUILT, [], np.array([[400.0, 0.0, np.pi]]))
