"""Commands that were read or rounded in coarse steps are known by themselves."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from armtwin.calib.diagnosis.lattice import command_lattices
from armtwin.models.recordings.reader import read_recording

DATA = Path(__file__).parents[4] / "shared" / "data" / "brachiograph"


def lattices(angles: object) -> list[tuple[int, float]]:
    return [(found.joint, found.step_rad) for found in command_lattices(np.asarray(angles).reshape(len(angles), -1))]  # type: ignore[arg-type]


@pytest.mark.parametrize("step_deg", [0.1, 0.5, 1.0, 5.0])
@pytest.mark.parametrize("seed", range(3))
def test_whole_steps_are_recognised_whatever_the_offset(step_deg: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    step = np.radians(step_deg)
    angles = rng.uniform(-0.5, 0.5) + step * rng.integers(-40, 40, 30)
    ((joint, found),) = lattices(angles)
    assert joint == 1
    assert found == pytest.approx(step, rel=1e-6)


def test_angles_written_with_six_digits_are_recognised_too() -> None:
    rng = np.random.default_rng(4)
    ((_, found),) = lattices(np.round(np.radians(rng.integers(-90, 90, 25)), 6))
    assert found == pytest.approx(np.radians(1.0), rel=1e-5)


def test_a_few_values_that_were_read_more_finely_do_not_hide_the_scale() -> None:
    rng = np.random.default_rng(5)
    angles = np.radians(rng.choice(np.arange(-90, 90), 30, replace=False)).astype(float)
    angles[:3] += np.radians([0.31, 0.57, 0.44])
    (found,) = command_lattices(angles[:, None])
    assert found.step_rad == pytest.approx(np.radians(1.0), rel=1e-6)
    assert (found.on_lattice, found.poses) == (27, 30)


@given(st.integers(0, 10**6), st.integers(2, 80))
def test_angles_anywhere_lie_on_no_scale(seed: int, n: int) -> None:
    assert lattices(np.random.default_rng(seed).uniform(-1.5, 1.5, (n, 1))) == []


@pytest.mark.parametrize("n", [2, 10, 100])
def test_an_evenly_planned_sweep_is_a_plan_and_no_scale(n: int) -> None:
    sweep = np.linspace(-0.7, 0.6, n)
    assert lattices(np.concatenate([sweep, sweep[::-1]])) == []


def test_steps_too_fine_to_matter_are_not_mentioned() -> None:
    rng = np.random.default_rng(6)
    assert lattices(1e-4 * rng.integers(-5000, 5000, 40)) == []


def test_each_joint_is_looked_at_by_itself() -> None:
    rng = np.random.default_rng(7)
    q = rng.uniform(-1.0, 1.0, (40, 3))
    q[:, 1] = np.radians(2.0) * np.round(q[:, 1] / np.radians(2.0))
    assert lattices(q) == [(2, pytest.approx(np.radians(2.0), rel=1e-6))]


def test_reading_within_a_step_has_the_spread_of_an_even_distribution() -> None:
    rng = np.random.default_rng(8)
    true = rng.uniform(-1.0, 1.0, 4000)
    read = np.radians(1.0) * np.round(true / np.radians(1.0))
    (found,) = command_lattices(read[:, None])
    assert found.reading_std_rad == pytest.approx(np.std(read - true), rel=0.05)


@pytest.mark.parametrize(("name", "on", "of"), [("shoulder", 20, 20), ("elbow", 15, 17)])
def test_the_pulse_widths_of_real_servos_were_read_in_steps_of_ten_microseconds(name: str, on: int, of: int) -> None:
    if not DATA.is_dir():
        pytest.skip(f"the measurements in {DATA.parent} are not here")
    (found,) = command_lattices(read_recording(DATA / name).q_cmd)
    assert found.step_rad == pytest.approx(np.radians(1.0), rel=1e-5)  # 10 us by the nominal map, 10 us a degree
    assert (found.on_lattice, found.poses) == (on, of)
