"""What an arm calibration finds, with how well it is known."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from armtwin.models.kinematics import Deviation
from armtwin.models.tabular import html_table

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Outlier:
    """A measurement that was left out: the pose's sample number, the marker (or joint), and how far off it was."""

    sample: int
    marker: str
    residual: float


@dataclass(frozen=True, eq=False)
class ArmCalibration:
    """The built arm against its drawing.

    Attributes:
        method: "least-squares", "joint-angles" or "algorithm-1".
        deviation: what to hand to `armtwin.models.kinematics.inverse(delta=...)`.
        base_in_board_mm: (3,) marker A in the board frame; None where only angles were measured.
        names: of the P parameters, units in the names.
        values, covariance: (P,) and (P, P); covariance is NaN where the method gives none.
        degrees_of_freedom: of the noise estimate, for the t intervals.
        clustered_std: (P,) standard deviations that also hold when the markers of one pose err together, as with joint
            play; where they are much larger than `std`, the errors are not the camera's.
        identifiable: how many link parameters can be known (six of planar3's seven).
        singular_values: see `armtwin.calib.arm.identifiability`.
        gauge, ties: what cannot be known, in words, with the convention used.
        noise: standard deviation of one measured coordinate as the residuals show it: px, rad or mm by method.
        rms_px, rms_mm: root mean square distance of the used markers from the model; NaN where there is none.
        n_poses, n_used: poses, and single measurements used.
        outliers: measurements left out.

    """

    method: str
    deviation: Deviation
    base_in_board_mm: Array | None
    names: tuple[str, ...]
    values: Array
    covariance: Array
    degrees_of_freedom: int
    clustered_std: Array
    identifiable: int
    singular_values: Array
    gauge: tuple[str, ...]
    ties: tuple[str, ...]
    noise: float
    rms_px: float
    rms_mm: float
    n_poses: int
    n_used: int
    outliers: tuple[Outlier, ...]

    @property
    def std(self) -> Array:
        """(P,) standard deviations."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def intervals95(self) -> Array:
        """(P, 2) intervals that hold the truth in 95 of 100 recordings (Student's t, the noise being estimated)."""
        reach = stats.t.ppf(0.975, self.degrees_of_freedom) if self.degrees_of_freedom > 0 else np.nan
        return self.values[:, None] + np.array([-1.0, 1.0]) * (reach * self.std)[:, None]

    def columns(self) -> dict[str, Any]:
        """Return a row a parameter: its name, value, standard deviation and 95 % interval."""
        low, high = self.intervals95.T
        spread = {"std": self.std, "low95": low, "high95": high}
        return {"parameter": np.array(self.names), "value": self.values, **spread}

    def _repr_html_(self) -> str:
        return html_table(f"Arm calibration, {self.method}, {self.n_poses} poses", self.columns())

    def as_table(self) -> dict[str, Any]:
        """Return the calibration as plain data for a JSON file; keys carry units."""
        intervals = self.intervals95
        return {
            "method": self.method,
            "parameters": {
                name: {
                    "value": self.values[i],
                    "std": self.std[i],
                    "interval95": intervals[i],
                    "clustered_std": self.clustered_std[i],
                }
                for i, name in enumerate(self.names)
            },
            "lengths_mm": self.deviation.lengths_mm,
            "joints_rad": self.deviation.joints_rad,
            "base_in_board_mm": self.base_in_board_mm,
            "covariance": self.covariance,
            "identifiable": self.identifiable,
            "singular_values": self.singular_values,
            "gauge": list(self.gauge),
            "ties": list(self.ties),
            "noise": self.noise,
            "rms_px": self.rms_px,
            "rms_mm": self.rms_mm,
            "n_poses": self.n_poses,
            "n_used": self.n_used,
            "degrees_of_freedom": self.degrees_of_freedom,
            "outliers": [{"sample": o.sample, "marker": o.marker, "residual": o.residual} for o in self.outliers],
        }
