"""The image sensor: what a webcam makes of the light that its lens lets through.

    light --blur--> --vignetting, exposure--> full-well electrons --photon, read noise--> --8 bit--> picture

The response is linear: no gamma, no sharpening, no compression.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache, lru_cache
from typing import Any

import cv2
import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray
from scipy.special import ndtri

from armtwin.models.errors import InputError

Linear = NDArray[np.float32]
Image = NDArray[np.uint8]

# Levels of the table from which noise is drawn: one 16-bit random number a sample, standard deviation exactly 1,
# kurtosis 3.000, greatest value 4.3. It takes a quarter of the time of exact normal draws.
_NOISE_LEVELS = 1 << 16
# Rows worked on at a time, so that what lies between light and picture stays in the processor's cache.
_BAND_ROWS = 32


@dataclass(frozen=True)
class Sensor:
    """How the light becomes a picture. The defaults are our assumption of a webcam of about 2 MP in office light.

    Attributes:
        blur_sigma_px: standard deviation of the Gaussian point spread: lens, focus and pixel cross-talk; 0 for none.
        exposure: gain on the light; what exceeds 1 is overexposed.
        vignetting: share of the light lost in the picture's corners, growing with the square of the distance from its
            centre.
        full_well_electrons: electrons of a pixel at full scale; photon noise is their square root. 0 for none.
        read_noise_electrons: standard deviation of the noise of a dark pixel.
        exposure_time_s: for how long light is gathered: what moves meanwhile is blurred in a film.

    """

    blur_sigma_px: float = 0.7
    exposure: float = 1.0
    vignetting: float = 0.15
    full_well_electrons: float = 9000.0
    read_noise_electrons: float = 15.0
    exposure_time_s: float = 0.008

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not (math.isfinite(value) and value >= 0.0):
                raise InputError(f"sensor.{name} is {value}; a finite number of at least 0 is wanted")
        if self.exposure == 0.0:
            raise InputError("sensor.exposure is 0, which leaves every picture black; it must be positive")
        if self.vignetting >= 1.0:
            raise InputError(f"sensor.vignetting is {self.vignetting}; the share of light lost must be below 1")

    @property
    def noisy(self) -> bool:
        """Whether the sensor adds noise at all."""
        return self.full_well_electrons > 0.0

    def noise_levels(self, signal: float) -> float:
        """Return the standard deviation, in 8-bit levels, of a pixel whose mean is `signal` (1 is full scale)."""
        if not self.noisy:
            return 0.0
        return 255.0 * math.sqrt(signal / self.full_well_electrons + self._read_variance)

    @property
    def _read_variance(self) -> float:
        return (self.read_noise_electrons / self.full_well_electrons) ** 2


IDEAL = Sensor(
    blur_sigma_px=0.0, vignetting=0.0, full_well_electrons=0.0, read_noise_electrons=0.0, exposure_time_s=0.0
)


def expose(image_linear: Linear, sensor: Sensor, rng: Generator) -> Image:
    """Take the picture of a linear image: (H, W, 3) float32, 1 full scale, to (H, W, 3) uint8, same channel order.

    Photon counts are taken as normal, which holds from about ten electrons on. The same state of `rng` gives the same
    picture. Raises InputError for an image of another shape or type.
    """
    if image_linear.dtype != np.float32 or image_linear.ndim != 3 or image_linear.shape[2] != 3:
        raise InputError(
            f"a linear image is (height, width, 3) float32; {image_linear.shape} {image_linear.dtype} was given"
        )
    height, width = image_linear.shape[:2]
    light = _blur(image_linear, sensor.blur_sigma_px) if sensor.blur_sigma_px > 0.0 else image_linear
    gain = _gain(height, width, sensor.exposure, sensor.vignetting)
    picture = np.empty(light.shape, np.uint8)
    for top in range(0, height, _BAND_ROWS):
        band = slice(top, top + _BAND_ROWS)
        picture[band] = _record(cv2.multiply(light[band], gain[band]), sensor, rng)
    return picture


def _record(light: NDArray[Any], sensor: Sensor, rng: Generator) -> NDArray[Any]:
    """Add noise to exposed light and round it to 8 bits; what does not fit is cut off."""
    if not sensor.noisy:
        return cv2.addWeighted(light, 255.0, light, 0.0, 0.0, dtype=cv2.CV_8U)
    # In 8-bit levels the variance is 255^2 (signal / full well + read variance).
    scale = 255.0**2
    variance = cv2.addWeighted(light, scale / sensor.full_well_electrons, light, 0.0, scale * sensor._read_variance)
    noise = cv2.multiply(cv2.sqrt(variance), _normal(rng, light.size).reshape(light.shape))
    return cv2.addWeighted(light, 255.0, noise, 1.0, 0.0, dtype=cv2.CV_8U)


def _blur(light: Linear, sigma_px: float) -> Linear:
    # The kernel is cut at 4 sigma, where 0.006 % of its weight is left.
    size = 2 * math.ceil(4.0 * sigma_px) + 1
    kernel = cv2.getGaussianKernel(size, sigma_px, cv2.CV_32F)
    return np.asarray(cv2.sepFilter2D(light, cv2.CV_32F, kernel, kernel, borderType=cv2.BORDER_REPLICATE), np.float32)


@lru_cache(maxsize=4)
def _gain(height: int, width: int, exposure: float, vignetting: float) -> Linear:
    """(H, W, 3) share of the light that each pixel records."""
    u = (np.arange(width) - 0.5 * (width - 1)) / (0.5 * math.hypot(width, height))
    v = (np.arange(height) - 0.5 * (height - 1)) / (0.5 * math.hypot(width, height))
    gain = exposure * (1.0 - vignetting * (u[None, :] ** 2 + v[:, None] ** 2))
    three = np.repeat(gain[..., None], 3, axis=2).astype(np.float32)
    three.flags.writeable = False
    return three


@cache
def _quantiles() -> Linear:
    """Mid-quantiles of the normal distribution, scaled to a standard deviation of 1."""
    table = ndtri((np.arange(_NOISE_LEVELS) + 0.5) / _NOISE_LEVELS)
    return np.asarray(table / table.std(), np.float32)


def _normal(rng: Generator, count: int) -> Linear:
    return _quantiles()[rng.integers(0, _NOISE_LEVELS, count, dtype=np.uint16)]
