"""Tables of one servo, read off a protractor or an encoder: what is the servo's, and what the reading's."""

from __future__ import annotations

import numpy as np
import pytest

from armtwin.calib.diagnosis.diagnosis import Diagnosis, diagnose
from armtwin.calib.diagnosis.grain import reading_grains
from armtwin.models.arm import Arm
from armtwin.models.recordings.recording import Recording, make_samples

TWELVE_BITS_DEG = 360.0 / 4096.0


def table(
    gain: float = 1.0,
    *,
    every_deg: float = 10.0,
    jitter_deg: float = 0.0,
    play_deg: float = 0.0,
    read_to_deg: float = 1.0,
    bow_deg: float = 0.0,
    there_and_back: bool = True,
    seed: int = 0,
) -> Recording:
    """Return what is read of a servo swept over half a turn: a pointer pushed through its play, then rounded."""
    rng = np.random.default_rng(seed)
    up = np.arange(0.0, 180.1, every_deg)
    commands = np.concatenate([up, up[-2::-1]]) if there_and_back else up
    pointer, readings = -play_deg, []
    for command in commands:
        turned = gain * command + bow_deg * ((command - 90.0) / 90.0) ** 3
        pointer = min(max(pointer, turned - play_deg / 2.0), turned + play_deg / 2.0)
        readings.append(round((pointer + jitter_deg * rng.standard_normal()) / read_to_deg) * read_to_deg)
    return Recording(
        arm=Arm("servo", np.array([100.0]), np.zeros(2)),
        sample=make_samples(len(commands)),
        time_s=np.full(len(commands), np.nan),
        trajectory=np.full(len(commands), "sweep"),
        q_cmd=np.round(np.radians(commands), 8)[:, None],
        q_meas=np.round(np.radians(readings), 8)[:, None],
    )


def named(diagnosis: Diagnosis) -> set[str]:
    return {cause.active.effect.name for cause in diagnosis.causes}


def possible(diagnosis: Diagnosis) -> set[str]:
    return named(diagnosis) | {other.effect.name for cause in diagnosis.causes for other in cause.equivalents}


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(
    ("jitter", "read_to"), [(0.0, 1.0), (0.3, 1.0), (0.5, 1.0), (0.2, 0.5), (0.3, 2.0), (0.1, TWELVE_BITS_DEG)]
)
def test_of_a_servo_that_is_right_nothing_is_named_however_it_is_read(jitter: float, read_to: float, seed: int) -> None:
    found = diagnose(table(jitter_deg=jitter, read_to_deg=read_to, seed=seed))
    assert found.verdict == "none"


@pytest.mark.parametrize("every", [5.0, 10.0])
@pytest.mark.parametrize("gain", [0.9, 0.96, 1.04, 1.139])
@pytest.mark.parametrize(("jitter", "read_to"), [(0.0, 1.0), (0.2, 0.5), (0.1, TWELVE_BITS_DEG)])
def test_a_gain_is_the_servos_and_the_steps_are_the_readings(
    gain: float, every: float, jitter: float, read_to: float
) -> None:
    found = diagnose(table(gain, every_deg=every, jitter_deg=jitter, read_to_deg=read_to))
    assert named(found) == {"servo_gain"}
    (cause,) = found.causes
    assert abs(cause.active.values[0] - gain) < 4.0 * cause.std[0] + 1e-3
    assert cause.std[0] > 1e-4  # an interval of no width would deny the grain


@pytest.mark.parametrize("read_to", [0.5, 1.0])
def test_play_is_found_beside_the_grain(read_to: float) -> None:
    found = diagnose(table(play_deg=3.0, jitter_deg=0.2, read_to_deg=read_to))
    assert found.causes[0].active.effect.name == "backlash"
    # With a single turning point a horn that slipped there looks the same.
    assert possible(found) <= {"backlash", "hysteresis", "settling_lag", "joint_slip"}


def test_a_sweep_in_one_direction_tells_gain_and_curve() -> None:
    found = diagnose(table(1.1, every_deg=18.0, bow_deg=3.0, there_and_back=False, read_to_deg=0.15))
    assert possible(found) <= {"servo_gain", "servo_nonlinearity"}
    assert found.verdict in ("named", "ambiguous")


@pytest.mark.parametrize(("read_to", "step"), [(1.0, 1.0), (0.5, 0.5), (2.0, 2.0), (TWELVE_BITS_DEG, TWELVE_BITS_DEG)])
def test_the_grain_is_the_step_of_the_reading(read_to: float, step: float) -> None:
    (grain,) = reading_grains(table(1.07, every_deg=5.0, jitter_deg=0.3, read_to_deg=read_to))
    assert np.degrees(grain.step) == pytest.approx(step, rel=1e-3)


def test_angles_that_were_chosen_and_whose_commands_were_sought_are_no_coarse_reading() -> None:
    sought = table(1.07, every_deg=15.0)
    chosen = Recording(**{**vars(sought), "q_cmd": sought.q_meas, "q_meas": sought.q_cmd})
    assert all(np.degrees(grain.step) <= 1.001 for grain in reading_grains(chosen))


def test_fine_readings_have_no_grain() -> None:
    assert reading_grains(table(jitter_deg=0.3, read_to_deg=1e-7)) == []


@pytest.mark.parametrize("marks_deg", [10.0, 15.0])
def test_marks_that_commands_were_sought_for_are_no_steps_of_the_servo(marks_deg: float) -> None:
    up = np.arange(30.0, 151.0, marks_deg)
    marks = np.concatenate([up, up[::-1]])
    side = np.repeat([1.0, -1.0], len(up))
    commands = 0.95 * marks + 2.0 * np.sin(np.radians(marks)) + 1.0 * side
    commands += 0.1 * np.random.default_rng(1).standard_normal(len(marks))
    found = diagnose(
        Recording(
            arm=Arm("servo", np.array([80.0]), np.zeros(2)),
            sample=make_samples(len(marks)),
            time_s=np.full(len(marks), np.nan),
            trajectory=np.where(side > 0, "cw", "acw"),
            q_cmd=np.round(np.radians(commands), 8)[:, None],
            q_meas=np.round(np.radians(marks), 8)[:, None],
        )
    )
    assert "quantization" not in possible(found)


def test_a_joint_whose_commands_are_coarse_is_read_as_finely_as_the_others() -> None:
    rng = np.random.default_rng(4)
    q = rng.uniform(-0.6, 0.6, (120, 2))
    coarse = q.copy()
    coarse[:, 1] = np.round(q[:, 1] / np.radians(3.0)) * np.radians(3.0)
    found = Recording(
        arm=Arm("two", np.array([100.0, 80.0]), np.zeros(2)),
        sample=make_samples(len(q)),
        time_s=np.full(len(q), np.nan),
        trajectory=np.full(len(q), "anywhere"),
        q_cmd=q,
        q_meas=np.round(np.round(coarse / np.radians(0.3)) * np.radians(0.3), 8),
    )
    assert [round(float(np.degrees(grain.step)), 3) for grain in reading_grains(found)] == [0.3, 0.3]
    assert named(diagnose(found)) == {"quantization"}
