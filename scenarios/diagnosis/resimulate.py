"""The recording made again by its extended twin in MuJoCo, and how far the two are apart."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.diagnosis.diagnosis import Diagnosis
from armtwin.calib.diagnosis.holdout import in_millimetres
from armtwin.calib.diagnosis.problem import Problem
from armtwin.models.catalogue.registry import effect_named
from armtwin.models.kinematics import wrap
from armtwin.models.recordings.part import Part, fair_part, part_of
from armtwin.models.recordings.recording import Recording
from armtwin.models.twin import Twin, rebuild
from armtwin.scenarios.diagnosis.remainder import sightings
from armtwin.sim.observe import pixels_of
from armtwin.sim.physics.simulation import default_clock, simulate, simulate_angles

Array = NDArray[np.float64]

# A pose takes MuJoCo two milliseconds to settle; of more than these a fair part is simulated.
_MOST_POSES = 400


@dataclass(frozen=True, eq=False)
class Resimulation:
    """A recording against its twin in MuJoCo.

    Attributes:
        channels: (N, M, d) what the simulated bench shows, in pixels or radians.
        miss_mm: (N, M) distance from what was recorded, NaN where nothing was seen.
        rms_mm: over every sighting that counts.
        held_out_rms_mm: over those of the poses that nothing was fitted to.

    """

    channels: Array
    miss_mm: Array
    rms_mm: float
    held_out_rms_mm: float


def resimulate(twin: Twin, recording: Recording, markers: tuple[str, ...]) -> Array:
    """(N, M, 2) pixels of `markers`, or for a twin without camera (N, n, 1) link angles, of the rebuilt bench.

    Detection is left out: a twin says where the markers are, not what is mistaken for them.
    """
    world = replace(rebuild(twin), detections=())
    clock = recording.time_s if recording.has_time else default_clock(len(recording))
    payload = None if recording.payload_kg is None else np.nan_to_num(recording.payload_kg)
    if twin.camera is None:
        return simulate_angles(world, recording.q_cmd, clock, payload, recording.commanded_s)[..., None]
    points = simulate(world, recording.q_cmd, clock, payload, recording.commanded_s)
    pixels = pixels_of(world, points, clock)
    return np.stack([pixels[name] for name in markers], axis=1)


def compare(diagnosis: Diagnosis, twin: Twin, recording: Recording) -> Resimulation:
    """Resimulate a diagnosed recording, of a long one a fair part, with its twin, and measure how far it is off."""
    problem = diagnosis.problem
    part = fair_part(len(recording), _MOST_POSES)
    some = resimulate(_at_rows(twin, part, len(recording)), part_of(recording, part), problem.context.markers)
    channels = np.full((len(recording), *some.shape[1:]), np.nan)
    channels[part.rows[part.counted]] = some[part.counted]
    seen = sightings(diagnosis)
    residual = np.where(seen.counts[..., None], seen.observed - channels, np.nan)
    miss = _length_mm(problem, diagnosis.explanation.final.g, residual)
    return Resimulation(channels, miss, _rms(miss), _rms(miss[diagnosis.held_rows]))


def _at_rows(twin: Twin, part: Part, n: int) -> Twin:
    """Return a twin of n rows as it is at those of a part: what happens between them happens at the next."""
    if len(part.rows) == n:
        return twin

    def here(value: Any) -> Any:
        if isinstance(value, list):
            return sorted({int(part.here(float(row), n)) for row in value if row in part.rows})
        return int(part.here(float(value), n))

    effects = []
    for one in twin.effects:
        takes = effect_named(one.effect).injected
        rows = {taken.name for taken in takes if taken.kind in ("sample", "samples")}
        rows |= {f"samples{joint}" for joint in range(1, twin.arm.n_joints + 1)}
        parameters = {name: here(value) if name in rows else value for name, value in one.parameters.items()}
        effects.append(replace(one, parameters=parameters))
    return replace(twin, effects=tuple(effects))


def _length_mm(problem: Problem, g: Array, residual: Array) -> Array:
    if not problem.is_pixels:  # angles may differ by whole turns
        residual = wrap(residual)
    return np.sqrt((in_millimetres(problem, g, residual) ** 2).sum(axis=-1))


def _rms(values: Array) -> float:
    return float(np.sqrt(np.nanmean(values**2))) if np.isfinite(values).any() else float("nan")
