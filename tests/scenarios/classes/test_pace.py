"""How long a sealed bench takes says nothing of what is in it."""

from __future__ import annotations

import time

import numpy as np
import pytest

from armtwin.models.arm import nominal_arm
from armtwin.scenarios.classes.sealed_bench import SealedBench
from armtwin.scenarios.serving.pace import Pace
from armtwin.sim.sealed import draw_world


@pytest.mark.parametrize("effect", [None, "backlash"])
def test_a_move_takes_as_long_with_play_as_without(effect: str | None) -> None:
    rng = np.random.default_rng(3)
    markers = nominal_arm().marker_names
    world = draw_world(rng, effect, "strong", n_poses=40, noise_px=0.06, markers=markers, missing=0.0).world
    pace = Pace()
    took = []
    with SealedBench(world, np.random.default_rng(1), pace) as bench:
        pace.pay()
        for q in rng.uniform(-0.4, 0.4, (9, 3)):
            began = time.monotonic()
            bench.move(q)
            pace.pay()
            took.append(time.monotonic() - began)
    assert np.median(took) == pytest.approx(0.1, abs=0.01)


def test_what_takes_longer_than_a_beat_takes_two() -> None:
    pace, began = Pace(), time.monotonic()
    with pace.beats(0.05):
        time.sleep(0.06)
    pace.pay()
    assert time.monotonic() - began >= 0.1
    began = time.monotonic()
    pace.pay()
    assert time.monotonic() - began < 0.04  # it is paid once
