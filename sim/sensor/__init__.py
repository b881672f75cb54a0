"""The webcam's sensor: `expose(linear_image, Sensor(...), rng)` turns light into a noisy 8-bit picture."""

from armtwin.sim.sensor.sensor import IDEAL, Sensor, expose

__all__ = ["IDEAL", "Sensor", "expose"]
