"""Numbers as Rojas Urzulo et al. (2023) print them, to be shown beside ours. Angles in rad."""

from __future__ import annotations

import math

TABLE_1_MM = {"l1": 120.00, "l2": 121.70, "l4": 38.00, "l5": 6.73}

TABLE_2 = {
    "fx": 1438.6338,
    "fy": 1439.1291,
    "cx": 654.1560,
    "cy": 369.6557,
    "k1": 0.1630,
    "k2": 0.0428,
    "p1": 0.0064,
    "p2": 0.0016,
    "k3": -2.1819,
    "tx": 118.6608,
    "ty": 41.3400,
    "tz": 565.4370,
}

# Three calibrations, mm and rad.
TABLE_4 = {
    "delta_l1_mm": (6.6740, 6.7015, 6.6341),
    "delta_l2_mm": (4.5566, 4.5704, 4.5967),
    "delta_l4_mm": (-0.6543, -0.7074, -0.6110),
    "delta_l5_mm": (0.9701, 1.0208, 1.0120),
    "delta_theta1_rad": tuple(math.radians(v) for v in (1.0875, 1.1354, 1.0304)),
    "delta_theta2_rad": tuple(math.radians(v) for v in (1.0521, 1.0037, 1.0231)),
    "delta_theta3_rad": tuple(math.radians(v) for v in (4.7973, 4.7563, 4.7755)),
}
TABLE_4_UNCERTAINTY = {
    "delta_l1_mm": 0.0339,
    "delta_l2_mm": 0.0204,
    "delta_l4_mm": 0.0483,
    "delta_l5_mm": 0.0271,
    "delta_theta1_rad": math.radians(0.0526),
    "delta_theta2_rad": math.radians(0.0244),
    "delta_theta3_rad": math.radians(0.0205),
}

# Section 5.2: mean error on the validation line.
VALIDATION = {"mean_before_mm": 4.0064, "mean_after_mm": 1.8186, "reduction_percent": 54.6076}
