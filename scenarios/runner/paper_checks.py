"""What the paper's equations do as they are printed."""

from __future__ import annotations

import numpy as np

from armtwin.models.arm import nominal_arm
from armtwin.models.kinematics import forward
from armtwin.models.trajectories import paper_trajectories


def printed_equation_8_error_mm() -> float:
    """Largest distance, mm, of forward(inverse(p)) from p on the paper's circles with equation (8) as printed."""
    arm = nominal_arm()
    l1, l2, l4, l5 = arm.link_lengths_mm
    paths = paper_trajectories()
    poses = np.concatenate([paths["circle_15"], paths["circle_25"]])
    x, y, theta_F = poses.T
    Cx = x - l4 * np.sin(theta_F - np.pi) + l5 * np.cos(theta_F - np.pi)
    Cy = y + l4 * np.cos(theta_F - np.pi) + l5 * np.sin(theta_F - np.pi)
    theta2 = -np.arcsin((Cx**2 + Cy**2 - l1**2 - l2**2) / (2 * l1 * l2))
    s2, c2 = np.sin(theta2), np.cos(theta2)
    theta1 = -np.arctan((Cy * l2 * c2 - Cx * (l2 * s2 - l1)) / (Cx * l2 * c2 + Cy * (l2 * s2 - l1)))
    q = np.stack([theta1, theta2, theta_F - theta1 - theta2 - np.pi], axis=-1)
    return float(np.linalg.norm(forward(arm, q)[:, :2] - poses[:, :2], axis=1).max())
