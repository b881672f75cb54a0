"""The emulated bench filmed: the real firmware's own frames and slew limit show in the angles."""

from pathlib import Path

import numpy as np
import pytest

from armtwin.calib.markers import measure_recording
from armtwin.calib.motion.diagnosis import diagnose_motion
from armtwin.hardware.capture.film import film
from armtwin.models.plan import Plan
from armtwin.models.recordings.moving_reader import read_moving
from armtwin.models.recordings.reader import read_recording
from armtwin.scenarios.benches.door import open_bench
from armtwin.scenarios.film_angles import angles_of_film, write_moving


@pytest.mark.slow
@pytest.mark.avr
def test_the_firmware_goes_no_faster_than_its_slew_limit_and_the_film_shows_it(tmp_path: Path) -> None:
    rows = 24
    q = np.zeros((rows, 3))
    q[6:, 0] = 0.4
    plan = Plan(np.full(rows, "step"), q, np.zeros(rows))
    with open_bench("emulated") as bench:
        film(bench, plan, np.arange(rows) / 10.0, tmp_path / "film")  # type: ignore[arg-type]
    seen = angles_of_film(measure_recording(read_recording(tmp_path / "film", unmeasured=True, film=True)))
    assert seen.q_meas is not None
    angle, time_s = seen.q_meas[:, 0], seen.time_s
    known = np.isfinite(angle)
    assert abs(angle[known][0]) < 0.15
    assert angle[known][-1] - angle[known][0] == pytest.approx(0.4, abs=0.02)
    fastest = np.abs(np.diff(angle[known]) / np.diff(time_s[known])).max()
    assert 0.5 < fastest < 1.15 * np.pi  # 40 us in each frame of 20 ms: 180 degrees a second


@pytest.mark.slow
@pytest.mark.avr
def test_its_slew_limit_and_the_wait_for_its_next_frame_are_named_however_busy_the_machine_is(tmp_path: Path) -> None:
    rate_hz, seconds = 25.0, 6.0
    t = np.arange(0.0, seconds, 1.0 / rate_hz)
    swings = [0.45 * np.sin(2 * np.pi * (low + 0.1 * t) * t) for low in (0.5, 0.7)]
    q = np.zeros((2 * len(t), 3))
    q[:, 1] = np.concatenate(swings)
    plan = Plan(np.repeat(["first", "second"], len(t)), q, np.zeros(len(q)))
    with open_bench("emulated") as bench:
        film(bench, plan, np.arange(len(q)) / rate_hz, tmp_path / "film")  # type: ignore[arg-type]
    seen = angles_of_film(measure_recording(read_recording(tmp_path / "film", unmeasured=True, film=True)))
    np.testing.assert_allclose(np.diff(seen.time_s), 1.0 / rate_hz, atol=1e-5)
    write_moving(tmp_path / "log", seen)
    found = diagnose_motion(read_moving(tmp_path / "log"))
    causes = {cause.effect: cause.parameters for cause in found.causes if cause.joint in (2, None)}
    # 40 us in each frame of 20 ms are pi rad/s; a way that is sent in whole frames takes a little longer.
    assert 2.4 < causes["speed_limit"]["speed_rad_s"].value < 1.02 * np.pi
    assert 0.003 < causes["latency"]["delay_s"].value < 0.03
