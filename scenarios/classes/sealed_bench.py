"""A student's bench: a simulated one that tells nothing of what is true of it."""

from __future__ import annotations

from dataclasses import replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from armtwin.models.bench import BenchDescription, Frame
from armtwin.models.errors import InputError, JobError
from armtwin.models.world import World
from armtwin.scenarios.serving.pace import Pace
from armtwin.sim.bench import SimulatedBench

# An arm with play takes 17 ms to move and 0.4 s to set up, one without 2 ms and 0.3 s.
_MOVE_BEAT_S, _CONNECT_BEAT_S = 0.1, 0.6


class SealedBench:
    """Satisfies `armtwin.models.bench.Bench`; unlike a `SimulatedBench` it has nothing that says what is true."""

    def __init__(self, world: World, seed: np.random.Generator, pace: Pace | None = None) -> None:
        self._pace = pace or Pace()
        self._bench = SimulatedBench(world, seed=seed)

    @property
    def description(self) -> BenchDescription:
        """What is declared: the drawing and the camera's file."""
        return replace(self._bench.description, kind="sealed", actuation={})

    @property
    def notes(self) -> tuple[str, ...]:
        """Nothing."""
        return ()

    @property
    def detached(self) -> bool:
        """Whether the bench is closed."""
        return self._bench.detached

    @property
    def clock_origin_s(self) -> None:
        """None: its time is the simulation's."""

    def connect(self) -> None:
        """Set the arm up in its home pose."""
        with self._pace.beats(_CONNECT_BEAT_S):
            self._bench.connect()

    def move(self, q_cmd_rad: NDArray[np.float64]) -> None:
        """Move; whatever the physics says of a pose that it cannot do is not passed on."""
        try:
            with self._pace.beats(_MOVE_BEAT_S):
                self._bench.move(q_cmd_rad)
        except InputError:
            raise
        except Exception:  # noqa: BLE001  # its words could tell what is in it
            raise JobError("the arm cannot go there; choose another pose") from None

    def hang(self, payload_kg: float) -> None:
        """Hang a known mass at the tip before the next move."""
        self._bench.hang(payload_kg)

    def capture(self) -> Frame:
        """Take a picture of the arm as it stands."""
        return self._bench.capture()

    def close(self) -> None:
        """Free the renderer; safe to call twice."""
        self._bench.close()

    def __enter__(self) -> Self:
        self.connect()
        return self

    def __exit__(self, *error: object) -> None:
        self.close()
