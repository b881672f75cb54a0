import numpy as np

from armtwin.calib.arm.chain import Chain
from armtwin.calib.arm.observations import observe
from armtwin.calib.arm.start import start
from armtwin.models.arm import nominal_arm

ROWS = np.arange(100)


def started(recording):
    return start(Chain(recording.arm), observe(recording, ROWS), recording.camera, recording.arm_plane_z_mm)


def test_the_linear_start_is_exact_without_noise(simulate, table_4_deviation):
    truth = Chain(nominal_arm()).in_convention(table_4_deviation)
    x = started(simulate(delta=table_4_deviation))
    np.testing.assert_allclose(x[:4], truth.lengths_mm, atol=1e-5)
    np.testing.assert_allclose(x[4:7], truth.joints_rad, atol=1e-6)
    np.testing.assert_allclose(x[7:], [-35.0, -20.0], atol=1e-5)


def test_a_third_of_gross_errors_does_not_carry_the_start_away(simulate, table_4_deviation):
    truth = Chain(nominal_arm()).in_convention(table_4_deviation)
    recording = simulate(delta=table_4_deviation, noise_px=0.06)
    rng = np.random.default_rng(0)
    for pixels in recording.markers_px.values():
        wrong = rng.random(len(pixels)) < 0.33
        pixels[wrong] += rng.uniform(-200, 200, (int(wrong.sum()), 2))
    x = started(recording)
    np.testing.assert_allclose(x[:2], truth.lengths_mm[:2], atol=0.5)
    np.testing.assert_allclose(x[4:7], truth.joints_rad, atol=0.01)


def test_large_turns_of_the_horns_are_found(simulate):
    chain = Chain(nominal_arm())
    delta = chain.deviation(np.array([10.0, -8.0, 0.0, 0.0, 0.8, -1.0, 0.6]))
    x = started(simulate(delta=delta))
    np.testing.assert_allclose(x[4:7], [0.8, -1.0, 0.6], atol=1e-4)
