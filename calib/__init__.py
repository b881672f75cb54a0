"""Learns from data: marker measurement, camera and arm calibration, diagnosis."""
