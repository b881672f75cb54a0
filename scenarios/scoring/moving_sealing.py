"""Make the logs of a sealed set of moving arms."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from pydantic import BaseModel

from armtwin.models import atomic
from armtwin.models.validation import Finite, Positive
from armtwin.scenarios.scoring.orders import Kind, Order
from armtwin.sim.sealed_motion.draw import draw_log
from armtwin.sim.sealed_motion.writing import write_log


class HiddenInMotion(BaseModel):
    """What the score reads of an effect that is hidden in a log."""

    effect: str
    joint: int | None
    marker: None
    parameters: dict[str, Any]
    moved_noises: Finite


class LogTruth(BaseModel):
    """What the score reads of a log; further keys are for people."""

    kind: Kind
    effects: list[HiddenInMotion]
    n_rows: int
    noise_rad: list[Positive]


def make_log(folder: Path, order: Order, rng: np.random.Generator) -> dict[str, Any]:
    """Make one log, write its recording into `folder` and return the truth about it."""
    log = draw_log(rng, order.effects)
    with atomic.folder_aside(folder) as aside:
        write_log(aside, log)
    return {"kind": order.kind, **log.truth}
