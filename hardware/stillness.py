"""Whether the arm is still in the picture: the difference of two frames against the camera's noise.

    command     |-- moving --|
    arm              /~~~~~~~~~~~\\________________      it lags, swings and creeps
    picture             /~~~~~~~~~~~\\_____________      the stream adds its own delay
                        ^ onset      ^ still for still_s -> the picture is taken

Waiting for the onset first is what makes a late stream harmless: until the old picture has changed, an equal pair of
frames only says that nothing has arrived yet.
"""

from __future__ import annotations

import itertools
from collections import deque
from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

Grey = NDArray[np.uint8]

# Noise averages out over a block, in which a contrasting edge that moves by a third of a pixel stands out.
BLOCK_PX = 16
# Above the loudest pair of a dozen still frames: a louder one is rare then, and only costs another frame.
_NOISE_MARGIN = 1.15
_ROUNDING_LEVELS = 0.1
MIN_FRAMES = 4


def to_grey(image: NDArray[np.uint8]) -> Grey:
    """(H, W) luminance of an (H, W, 3) BGR picture."""
    return np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY), dtype=np.uint8)


def difference(a: Grey, b: Grey) -> float:
    """Largest mean absolute difference of two (H, W) pictures over 16x16 px blocks, grey levels."""
    height, width = a.shape
    size = (max(1, width // BLOCK_PX), max(1, height // BLOCK_PX))
    change = cv2.absdiff(a, b).astype(np.float32)
    return float(cv2.resize(change, size, interpolation=cv2.INTER_AREA).max())


def noise_level(frames: Sequence[Grey]) -> float:
    """Loudest difference between neighbours of at least three frames of a still scene, grey levels."""
    return max(difference(a, b) for a, b in itertools.pairwise(frames))


class StillnessWatch:
    """Fed with the frames after a move, tells when the arm has come to rest.

    `reference` is the picture before the move; with None no onset is waited for. `onset_by_s` is when to give up on it,
    `earliest_s` the end of the commanded motion, both on the clock of the frames' arrival.
    """

    def __init__(
        self, noise: float, still_s: float, earliest_s: float, reference: Grey | None = None, onset_by_s: float = 0.0
    ) -> None:
        self.threshold = _NOISE_MARGIN * noise + _ROUNDING_LEVELS
        self._still_s = still_s
        self._earliest_s = earliest_s
        self._reference = reference
        self._onset_by_s = onset_by_s
        self._moved = reference is None
        self._window: deque[tuple[float, Grey]] = deque()

    @property
    def moved(self) -> bool:
        """Whether the picture has changed since the reference."""
        return self._moved

    def feed(self, frame: Grey, arrived_s: float) -> bool:
        """Take the next frame; True when the arm is still in it and has been for long enough."""
        if self._reference is not None and not self._moved:
            self._moved = difference(self._reference, frame) > self.threshold
        self._window.append((arrived_s, frame))
        # Against every frame of the window, not the last alone: a slow creep shows in none of the small steps.
        while len(self._window) > 1 and difference(self._window[0][1], frame) > self.threshold:
            self._window.popleft()
        while len(self._window) > MIN_FRAMES and arrived_s - self._window[1][0] >= self._still_s:
            self._window.popleft()
        rested = len(self._window) >= MIN_FRAMES and arrived_s - self._window[0][0] >= self._still_s
        return rested and arrived_s >= self._earliest_s and (self._moved or arrived_s >= self._onset_by_s)
