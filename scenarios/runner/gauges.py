"""The vision system's evaluation: gauges of known length, placed about the arm's plane (section 5.1.1, Table 3)."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.gauges import PAPER_TABLE_3, evaluate, measure_gauges
from armtwin.calib.markers import Method
from armtwin.models.atomic import folder_aside
from armtwin.models.camera import back_project
from armtwin.scenarios.benches.simulated import simulated_bench
from armtwin.scenarios.runner.camera import calibrated_camera
from armtwin.scenarios.runner.frames import Image, write_frame
from armtwin.scenarios.runner.job import Job
from armtwin.scenarios.runner.picture import generator
from armtwin.scenarios.runner.stage import Tick
from armtwin.scenarios.runner.world import true_camera
from armtwin.scenarios.scenario import ScenarioFile
from armtwin.sim.bench import SimulatedBench
from armtwin.sim.render import gauge_disc_radius_mm

Array = NDArray[np.float64]

METHODS: tuple[Method, ...] = ("paper", "subpixel")
# From a gauge's middle to the farthest point of its block is half its length and this much, mm.
_AROUND_MM = 16.0
# On the arm's plane a millimetre is about 3 px in Table 2's picture.
_PX_PER_MM = 3.0


def evaluate_gauges(job: Job, tick: Tick) -> dict[str, Any]:
    """Place every gauge, measure it by both detectors in the same pictures, and gather Table 3.

    The first picture of each gauge is kept.
    """
    scenario, camera = job.scenario, calibrated_camera(job)
    lengths, n = scenario.gauge_lengths_mm, scenario.gauge_placements
    measured: dict[str, dict[float, Array]] = {method: {} for method in METHODS}
    with folder_aside(job.out / "gauges") as folder, closing(simulated_bench(scenario, "gauges")) as bench:
        for number, length in enumerate(lengths):
            images = _pictures(scenario, bench, number, folder)
            counted = _counted(images, partial(_tick_from, tick, number * n, n * len(lengths)))
            radius = gauge_disc_radius_mm(length)
            found = measure_gauges(counted, length, radius, camera, scenario.bench.arm_plane_z_mm, METHODS)
            for method, values in found.items():
                measured[method][length] = values
    rows = [_row(method, length, measured[method][length]) for method in METHODS for length in lengths]
    return {"rows": rows, "measured_mm": measured}


def _pictures(scenario: ScenarioFile, bench: SimulatedBench, number: int, folder: Path) -> Iterator[Image]:
    """Yield a picture of gauge `number` at every placement, anywhere in the picture and turned at random."""
    length = scenario.gauge_lengths_mm[number]
    rng = generator(scenario, f"gauge {number}")
    camera = true_camera(scenario)
    margin = (length / 2 + _AROUND_MM) * _PX_PER_MM
    size = np.array([camera.image_width, camera.image_height])
    for placement in range(scenario.gauge_placements):
        pixel = rng.uniform(margin, size - margin)
        x, y, _ = back_project(camera, pixel[None], scenario.bench.arm_plane_z_mm)[0]
        pose = bench.gauge_placement(float(x), float(y), float(rng.uniform(0.0, np.pi)))
        image = bench.capture_gauge(length, pose).image
        if placement == 0:
            write_frame(folder, number, image)
        yield image


def _tick_from(tick: Tick, before: int, total: int, done: int) -> None:
    tick(before + done, total)


def _counted(images: Iterator[Image], count: Callable[[int], None]) -> Iterator[Image]:
    for number, image in enumerate(images, start=1):
        yield image
        count(number)


def _row(method: Method, length: float, measured_mm: Array) -> dict[str, Any]:
    """Return a row of Table 3; a detector that finds a gauge less than twice has no average and no U."""
    found = int(np.isfinite(measured_mm).sum())
    row: dict[str, Any] = {"detector": method, "length_mm": length, "n": found, "missed": len(measured_mm) - found}
    row |= dict.fromkeys(("average_mm", "bias_mm", "mean_square_error_mm2", "uncertainty_mm"))
    if found >= 2:
        row |= asdict(evaluate({length: measured_mm})[0])
    return row | {"paper": _paper_row(length)}


def _paper_row(length_mm: float) -> dict[str, Any] | None:
    return next((asdict(row) for row in PAPER_TABLE_3 if row.length_mm == length_mm), None)
