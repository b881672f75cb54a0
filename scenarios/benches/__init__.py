"""Benches by name: simulated, emulated, hardware and remote, opened by one door."""
