"""The emulated bench's pace: faster than real time, and the same arm in the picture."""

import numpy as np
import pytest

from armtwin.hardware.bench.bench_file import read_bench
from armtwin.hardware.bench.hardware_bench import HardwareBench
from armtwin.hardware.emulator import missing_packages
from armtwin.models.errors import InputError
from armtwin.scenarios.emulated_bench import EmulatedBench
from armtwin.scenarios.marker_finder import marker_finder

POSES = np.array([[0.1, 0.1, -0.1], [0.4, 0.3, -0.3], [0.2, -0.1, 0.2]])


def markers_at(speed: float) -> np.ndarray:
    """(poses, markers, 2) pixels that a capture of `POSES` shows."""
    with EmulatedBench(speed=speed) as emulated:
        setup = read_bench(emulated.bench_file)
        find = marker_finder(setup.arm, setup.camera, setup.arm_plane_z_mm)
        seen = []
        with HardwareBench(setup, find) as bench:
            for q in POSES:
                bench.move(q)
                found = find(bench.capture().image, q)
                seen.append([found[name] for name in setup.arm.marker_names])
    return np.array(seen)


@pytest.mark.avr
@pytest.mark.slow
@pytest.mark.skipif(bool(missing_packages()), reason=missing_packages() or "present")
def test_a_capture_at_twice_real_time_shows_the_same_arm():
    np.testing.assert_allclose(markers_at(2.0), markers_at(1.0), atol=0.05)  # px; the noise is a tenth of it


@pytest.mark.parametrize("speed", [0.0, -1.0, 4.5, float("nan")])
def test_a_speed_that_the_host_cannot_follow_is_refused(speed: float):
    with pytest.raises(InputError, match=r"speed of the emulated bench: .* is not between 0\.1 and 4"):
        EmulatedBench(speed=speed)
