"""The vision system's evaluation on length gauges (section 5.1.1, Table 3, equation 24).

A gauge shows two discs whose centres are its length apart. Each placement gives one measured length; of n placements of
one gauge come the average, the bias, the mean square error and the uncertainty U, the standard deviation (equation 24).
Table 3's three columns agree with one another when its mean square error is read as the mean of (q_j - length)^2 in
mm^2: bias^2 + U^2 (n - 1) / n gives each of its four values to the last digit.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.markers import DetectorConfig, Disc, Method, detect
from armtwin.models.camera import Camera, back_project, project_jacobian
from armtwin.models.errors import InputError

Array = NDArray[np.float64]
Image = NDArray[np.uint8]

# Radii that are sought, in shares of the drawn one: the plane may be off, and Hough circles are.
_RADIUS_SHARES = 0.6, 1.5
# Share of the length, and mm at least, by which a pair of discs may miss it and still be the gauge.
_LENGTH_SHARE, _LENGTH_MM = 0.2, 3.0


@dataclass(frozen=True)
class GaugeRow:
    """One row of Table 3.

    Attributes:
        length_mm: the gauge's length.
        n: placements that were measured; `missed` are those in which the gauge was not found.
        average_mm, bias_mm, uncertainty_mm: mean of the measured lengths, its difference to the length, and U.
        mean_square_error_mm2: mean of the squared errors.

    """

    length_mm: float
    n: int
    missed: int
    average_mm: float
    bias_mm: float
    mean_square_error_mm2: float
    uncertainty_mm: float


# Table 3 of the paper: 20 placements each.
PAPER_TABLE_3 = (
    GaugeRow(40.0, 20, 0, 40.2301, 0.2301, 0.0688, 0.1294),
    GaugeRow(30.0, 20, 0, 30.2279, 0.2279, 0.0651, 0.1175),
    GaugeRow(10.0, 20, 0, 10.2029, 0.2029, 0.0492, 0.0921),
    GaugeRow(5.0, 20, 0, 5.2320, 0.2320, 0.0595, 0.0776),
)


def evaluate(measured_mm: Mapping[float, Sequence[float] | Array]) -> tuple[GaugeRow, ...]:
    """Return a row for each gauge from its measured lengths, mm (NaN: not found), longest gauge first.

    Raises `InputError` where a gauge has fewer than two measurements, of which there is no uncertainty.
    """
    return tuple(_row(length, np.asarray(measured_mm[length], float)) for length in sorted(measured_mm, reverse=True))


def measure_gauge(
    image: Image,
    length_mm: float,
    disc_radius_mm: float,
    camera: Camera,
    plane_z_mm: float,
    method: Method = "subpixel",
) -> float:
    """Return the distance of a gauge's two disc centres on the plane, mm; NaN where the gauge is not found.

    `disc_radius_mm` is the radius that the discs are drawn with: Hough circles of the paper's method need the range.
    Of several pairs of discs about `length_mm` apart the one of the highest contrast is taken.
    """
    discs = detect(image, method, camera, plane_z_mm, _config(disc_radius_mm, camera, plane_z_mm))
    return _length(discs, length_mm, camera, plane_z_mm)


def measure_gauges(
    images: Iterable[Image],
    length_mm: float,
    disc_radius_mm: float,
    camera: Camera,
    plane_z_mm: float,
    methods: Sequence[Method] = ("paper", "subpixel"),
) -> dict[Method, Array]:
    """Return the measured lengths (n,) mm of one gauge's placements by each method, on the same images."""
    rows = [[measure_gauge(i, length_mm, disc_radius_mm, camera, plane_z_mm, m) for m in methods] for i in images]
    return {method: np.array(rows, float).reshape(-1, len(methods))[:, k] for k, method in enumerate(methods)}


def _config(disc_radius_mm: float, camera: Camera, plane_z_mm: float) -> DetectorConfig:
    middle = back_project(camera, camera.K[:2, 2][None], plane_z_mm)
    px_per_mm = float(np.sqrt(abs(np.linalg.det(project_jacobian(camera, middle)[0, :, :2]))))
    low, high = (share * disc_radius_mm * px_per_mm for share in _RADIUS_SHARES)
    return DetectorConfig(min_radius_px=low, max_radius_px=high)


def _length(discs: tuple[Disc, ...], length_mm: float, camera: Camera, plane_z_mm: float) -> float:
    places = back_project(camera, np.array([d.centre for d in discs]).reshape(-1, 2), plane_z_mm)
    slack = max(_LENGTH_MM, _LENGTH_SHARE * length_mm)
    pairs = [(float(np.linalg.norm(places[i] - places[j])), i, j) for i, j in combinations(range(len(discs)), 2)]
    fitting = [(length, i, j) for length, i, j in pairs if abs(length - length_mm) < slack]
    if not fitting:
        return float("nan")
    return max(fitting, key=lambda pair: discs[pair[1]].contrast + discs[pair[2]].contrast)[0]


def _row(length_mm: float, measured: Array) -> GaugeRow:
    found = measured[np.isfinite(measured)]
    if len(found) < 2:
        raise InputError(
            f"gauge of {length_mm:g} mm: found in {len(found)} of {len(measured)} pictures; at least 2 are needed"
        )
    average = float(found.mean())
    return GaugeRow(
        length_mm=length_mm,
        n=len(found),
        missed=len(measured) - len(found),
        average_mm=average,
        bias_mm=average - length_mm,
        mean_square_error_mm2=float(np.mean((found - length_mm) ** 2)),
        uncertainty_mm=float(np.std(found, ddof=1)),
    )
