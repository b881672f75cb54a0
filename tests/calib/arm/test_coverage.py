import numpy as np
import pytest

from armtwin.calib.arm import least_squares
from armtwin.calib.arm.chain import Chain
from armtwin.models.arm import nominal_arm
from armtwin.models.kinematics import Deviation

WORLDS = 200


@pytest.mark.parametrize("markers", ["abcf", "af"])
def test_the_95_percent_intervals_hold_the_truth_in_92_to_98_percent_of_200_worlds(simulate, markers):
    chain = Chain(nominal_arm())
    hits = np.zeros(9)
    for world in range(WORLDS):
        rng = np.random.default_rng(1000 + world)
        truth = chain.in_convention(Deviation(rng.normal(0, 4, 4), rng.normal(0, 0.05, 3)))
        recording = simulate(delta=truth, markers=markers, noise_px=rng.uniform(0.02, 0.3), seed=world)
        found = least_squares.calibrate(recording, ["circle_15", "circle_25"])
        expected = np.concatenate([truth.lengths_mm, truth.joints_rad, [-35.0, -20.0]])
        low, high = found.intervals95.T
        hits += (low <= expected) & (expected <= high)
    share = dict(zip(found.names, hits / WORLDS, strict=True))
    assert all(0.92 <= value <= 0.98 for value in share.values()), share


def test_the_intervals_also_hold_with_few_poses_and_unknown_noise(simulate):
    chain = Chain(nominal_arm())
    worlds = 3 * WORLDS
    hits = np.zeros(9)
    for world in range(worlds):
        rng = np.random.default_rng(5000 + world)
        truth = chain.in_convention(Deviation(rng.normal(0, 4, 4), rng.normal(0, 0.05, 3)))
        q = rng.uniform(-0.6, 0.6, (6, 3))
        found = least_squares.calibrate(simulate(delta=truth, q_cmd=q, markers="abcf", noise_px=0.1, seed=world))
        expected = np.concatenate([truth.lengths_mm, truth.joints_rad, [-35.0, -20.0]])
        low, high = found.intervals95.T
        hits += (low <= expected) & (expected <= high)
    share = dict(zip(found.names, hits / worlds, strict=True))
    assert all(0.92 <= value <= 0.98 for value in share.values()), share
