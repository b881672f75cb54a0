"""Makes a world from a model: physics, rendering, lens, sensor noise, the simulated bench."""
