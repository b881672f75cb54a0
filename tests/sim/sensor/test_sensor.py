"""The sensor does to light what its data sheet says, and the same thing for the same seed."""

from __future__ import annotations

import numpy as np
import pytest

from armtwin.models.errors import InputError
from armtwin.sim.sensor import IDEAL, Sensor, expose


def flat(level: float, height: int = 240, width: int = 320) -> np.ndarray:
    return np.full((height, width, 3), level, np.float32)


def noiseless(**changes: float) -> Sensor:
    return Sensor(**({"blur_sigma_px": 0.0, "vignetting": 0.0, "full_well_electrons": 0.0} | changes))


def test_an_ideal_sensor_rounds_to_the_nearest_level() -> None:
    levels = np.arange(256, dtype=np.float32).repeat(3).reshape(16, 16, 3) / np.float32(255.0)
    picture = expose(levels + np.float32(0.3 / 255.0), IDEAL, np.random.default_rng(0))
    assert picture.dtype == np.uint8
    assert np.array_equal(picture.ravel(), np.arange(256, dtype=np.uint8).repeat(3))


def test_light_beyond_full_scale_is_overexposed_and_none_is_black() -> None:
    rng = np.random.default_rng(0)
    assert np.all(expose(flat(0.7), noiseless(exposure=2.0), rng) == 255)
    assert np.all(expose(flat(0.0), noiseless(exposure=2.0), rng) == 0)


def test_exposure_is_a_gain() -> None:
    picture = expose(flat(0.2), noiseless(exposure=2.0), np.random.default_rng(0))
    assert np.all(picture == round(0.4 * 255))


def test_vignetting_takes_its_share_in_the_corners_and_none_in_the_centre() -> None:
    picture = expose(flat(0.8, 241, 321), noiseless(vignetting=0.25), np.random.default_rng(0))[..., 0]
    assert picture[120, 160] == round(0.8 * 255)
    for corner in (picture[0, 0], picture[0, -1], picture[-1, 0], picture[-1, -1]):
        assert corner == pytest.approx(0.75 * 0.8 * 255, abs=2.0)
    assert np.array_equal(picture, picture[::-1, ::-1])


@pytest.mark.parametrize("sigma_px", [0.5, 0.9, 2.5])
def test_blur_spreads_a_line_into_a_gaussian(sigma_px: float) -> None:
    line = flat(0.0)
    line[:, 160] = 1.0
    row = expose(line, noiseless(blur_sigma_px=sigma_px), np.random.default_rng(0))[120, :, 1]
    weights = np.exp(-0.5 * ((np.arange(320) - 160) / sigma_px) ** 2)
    assert np.abs(row - 255.0 * weights / weights.sum()).max() <= 0.51  # rounding to a level


def test_blur_moves_no_edge() -> None:
    step = flat(0.2)
    step[:, 160:] = 0.8
    before = step[120, :, 0].sum()
    after = expose(step, noiseless(blur_sigma_px=1.3), np.random.default_rng(0))[120, :, 0].sum() / 255.0
    assert after == pytest.approx(before, abs=0.02)


@pytest.mark.parametrize("signal", [0.05, 0.3, 0.9])
def test_noise_has_the_variance_of_photons_and_of_reading(signal: float) -> None:
    sensor = Sensor(blur_sigma_px=0.0, vignetting=0.0, full_well_electrons=4000.0, read_noise_electrons=25.0)
    picture = expose(flat(signal, 480, 640), sensor, np.random.default_rng(3)).astype(float)
    electrons = 4000.0 * signal
    expected = (255.0 / 4000.0) ** 2 * (electrons + 25.0**2) + 1.0 / 12.0  # and that of rounding
    assert picture.mean() == pytest.approx(255.0 * signal, abs=0.05)
    assert picture.var() == pytest.approx(expected, rel=0.01)
    assert sensor.noise_levels(signal) == pytest.approx(np.sqrt(expected - 1.0 / 12.0), rel=1e-9)


def test_noise_is_normal_and_differs_between_pixels_channels_and_pictures() -> None:
    sensor = Sensor(blur_sigma_px=0.0, vignetting=0.0, full_well_electrons=400.0)
    rng = np.random.default_rng(5)
    first, second = (expose(flat(0.5, 480, 640), sensor, rng).astype(float) for _ in range(2))
    z = (first - first.mean()) / first.std()
    assert np.mean(z**3) == pytest.approx(0.0, abs=0.02)
    assert np.mean(z**4) == pytest.approx(3.0, abs=0.05)
    other = second - second.mean()
    for a, b in [(z, other), (z[:, 1:], z[:, :-1]), (z[1:], z[:-1]), (z[..., 0], z[..., 1])]:
        assert abs(np.corrcoef(a.ravel(), b.ravel())[0, 1]) < 0.01


def test_the_same_seed_takes_the_same_picture() -> None:
    light = flat(0.4)
    one, same, another = (expose(light, Sensor(), np.random.default_rng(seed)) for seed in (7, 7, 8))
    assert np.array_equal(one, same)
    assert not np.array_equal(one, another)


def test_the_light_is_left_as_it_was() -> None:
    light = flat(0.4)
    expose(light, Sensor(exposure=1.7), np.random.default_rng(0))
    assert np.all(light == np.float32(0.4))


@pytest.mark.parametrize(
    ("changes", "key"),
    [
        ({"blur_sigma_px": -0.1}, "blur_sigma_px"),
        ({"exposure": 0.0}, "exposure"),
        ({"vignetting": 1.0}, "vignetting"),
        ({"full_well_electrons": float("nan")}, "full_well_electrons"),
        ({"read_noise_electrons": float("inf")}, "read_noise_electrons"),
    ],
)
def test_an_impossible_sensor_is_refused_by_name(changes: dict[str, float], key: str) -> None:
    with pytest.raises(InputError, match=f"sensor.{key}"):
        Sensor(**changes)


def test_an_image_that_is_not_linear_light_is_refused() -> None:
    with pytest.raises(InputError, match="float32"):
        expose(np.zeros((4, 4, 3), np.uint8), IDEAL, np.random.default_rng(0))  # type: ignore[arg-type]
