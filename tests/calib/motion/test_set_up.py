"""Gross errors of a moving log's set-up are told and mended; of a log that is right nothing is said."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from armtwin.calib.motion.set_up import mended
from armtwin.models.arm import Arm
from armtwin.models.recordings.moving import MovingRecording
from tests.support.strangers import streams, together, usual

Array = NDArray[np.float64]
DELAY_S = 0.05


@pytest.fixture(scope="module")
def right() -> MovingRecording:
    """Return the log of somebody's arm of four joints."""
    time, names, sent, read = together(streams(usual(4)))
    return MovingRecording(Arm("arm", np.full(4, 100.0), np.zeros(2)), time, names, sent, read)


def commands(recording: MovingRecording, of: Callable[[Array], Array]) -> MovingRecording:
    return replace(recording, q_cmd=of(recording.q_cmd.copy()))


def readings(recording: MovingRecording, of: Callable[[Array], Array]) -> MovingRecording:
    return replace(recording, q_meas=of(recording.q_meas.copy()))


def given(recording: MovingRecording, of: Callable[[Array], Array]) -> MovingRecording:
    return replace(recording, commanded_s=of(recording.time_s))


def test_of_a_log_that_is_right_nothing_is_said(right: MovingRecording) -> None:
    found = mended(right)
    assert found.faults == ()
    assert found.recording is right


def scaled(joint: int, factor: float) -> Callable[[Array], Array]:
    return lambda q: q * np.where(np.arange(q.shape[1]) == joint, factor, 1.0)


WRONG: dict[str, tuple[Callable[[MovingRecording], MovingRecording], tuple[str, tuple[int, ...]]]] = {
    "a joint that turns round": (lambda r: commands(r, scaled(1, -1.0)), ("joint_reversed", (2,))),
    "two columns exchanged": (lambda r: commands(r, lambda q: q[:, [0, 3, 2, 1]]), ("joints_exchanged", (2, 4))),
    "readings in degrees": (lambda r: readings(r, scaled(2, 57.29578)), ("degrees_for_radians", (3,))),
    "commands in degrees": (lambda r: commands(r, scaled(0, 57.29578)), ("degrees_for_radians", (1,))),
    "an encoder that wraps": (
        lambda r: readings(r, lambda q: np.where(np.arange(4) == 3, np.mod(q, 2 * np.pi), q)),
        ("whole_turns", (4,)),
    ),
}


@pytest.mark.parametrize("wrong", WRONG)
def test_what_is_set_up_wrongly_is_told_and_mended(right: MovingRecording, wrong: str) -> None:
    spoil, (error, joints) = WRONG[wrong]
    found = mended(spoil(right))
    assert [(fault.error, fault.joints) for fault in found.faults] == [(error, joints)]
    np.testing.assert_allclose(found.recording.q_cmd, right.q_cmd, atol=1e-6)
    np.testing.assert_allclose(found.recording.q_meas, right.q_meas, atol=1e-6)


def test_a_log_all_in_degrees_is_known_by_the_steps_of_its_encoder(right: MovingRecording) -> None:
    small = replace(right, q_cmd=np.degrees(right.q_cmd) / 12, q_meas=np.degrees(_coarse(right.q_meas / 12)))
    (fault,) = mended(small).faults
    assert (fault.error, fault.joints) == ("degrees_for_radians", (1, 2, 3, 4))
    assert "read in steps of 0.08789, a turn over 4096" in fault.said


def _coarse(q: Array) -> Array:
    count = 2 * np.pi / 4096
    return np.round(q / count) * count


@pytest.mark.parametrize("late_s", [0.1, 0.2, 0.35])
def test_an_arm_that_answers_before_it_is_told_has_two_clocks(right: MovingRecording, late_s: float) -> None:
    found = mended(given(right, lambda time: time + late_s))
    (fault,) = found.faults
    assert fault.error == "clock_offset"
    said_ms = float(fault.said.split("answers about ")[1].split(" ms")[0])
    assert said_ms == pytest.approx(1e3 * (late_s - DELAY_S), abs=15.0)


@pytest.mark.parametrize("rate", [0.003, -0.004, 0.01])
def test_a_clock_that_runs_faster_is_told_with_its_rate(right: MovingRecording, rate: float) -> None:
    found = mended(given(right, lambda time: (1.0 + rate) * time))
    assert found.faults[0].error == "clock_rate"
    assert ("fast" if rate > 0 else "slow") in found.faults[0].said
    assert found.recording.commanded_s is not None
    slope = np.polyfit(right.time_s, found.recording.commanded_s, 1)[0]
    assert slope == pytest.approx(1.0, abs=0.15 * abs(rate))


def test_a_bus_that_falls_behind_at_a_moment_is_no_clock(right: MovingRecording) -> None:
    late = given(right, lambda time: time - 0.25 * (time > 60.0))
    assert mended(late).faults == ()


def test_a_ramp_that_never_turns_back_says_nothing_of_clocks() -> None:
    time = 0.02 * np.arange(400)
    sent = np.linspace(-1.0, 1.0, 400)[:, None]
    ramp = MovingRecording(Arm("arm", np.full(1, 100.0), np.zeros(2)), time, np.full(400, "up"), sent, sent - 0.02)
    assert mended(ramp).faults == ()
