"""Arm calibration: the paper's Algorithm 1, and least squares in pixels with its identifiability."""
