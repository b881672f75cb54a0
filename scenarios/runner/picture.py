"""What a scenario says of its pictures, and its random numbers."""

from __future__ import annotations

import zlib

import numpy as np

from armtwin.scenarios.scenario import ScenarioFile
from armtwin.sim.sensor import Sensor


def sensor_of(scenario: ScenarioFile) -> Sensor:
    """Return the sensor that the scenario declares."""
    return Sensor(**scenario.picture.model_dump(exclude={"shadows"}))


def generator(scenario: ScenarioFile, purpose: str) -> np.random.Generator:
    """Return the random numbers of one purpose: the same in every run of a scenario, independent of other purposes."""
    return np.random.default_rng([scenario.seed, zlib.crc32(purpose.encode())])
