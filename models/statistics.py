"""Constants of the normal distribution, as everything here rounds them."""

from __future__ import annotations

# Standard deviation over median absolute deviation: 1 / norm.ppf(3 / 4).
MAD_TO_STD = 1.4826
# Half width of a 95 % interval in standard deviations: norm.ppf(0.975).
Z95 = 1.96
