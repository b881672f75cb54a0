"""Whether the arm is still in the picture: the difference of two frames against the camera's noise.

    command     |-- moving --|
    arm              /~~~~~~~~~~~\\________________      it lags, swings and creeps
    picture             /~~~~~~~~~~~\\_____________      the stream adds its own delay
                        ^ onset      ^ still for still_s -> the picture is taken

Waiting for the onset is what makes a late stream harmless: while the picture is still that from before the move, equal
frames only say that nothing has arrived yet.
"""

from __future__ import annotations

import itertools
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import cv2
import numpy as np
from numpy.typing import NDArray

Grey = NDArray[np.uint8]
Blocks = NDArray[np.float32]

# Noise averages out over a block, in which a contrasting edge that moves by a few tenths of a pixel stands out.
BLOCK_PX = 16
# Standard deviations beyond which a block has changed. A 720p picture has 3600 blocks and a capture looks at some ten
# thousand pictures: normal noise passes six in one capture of thirty, and a false alarm would end a wait too early.
_CHANGED = 7.0
# A codec's noise has longer tails: as far again beyond the loudest pair of the still scene.
_TAIL_MARGIN = 1.3
# Blocks without noise (black, clipped) still flicker by a rounding step here and there, grey levels.
_QUIETEST_LEVELS = 0.3
_LEAST_SPREAD = 0.01
# Width of a bin of brightness, over which a sensor's noise hardly changes.
_BIN_LEVELS = 8
MIN_FRAMES = 4


def to_grey(image: NDArray[np.uint8]) -> Grey:
    """(H, W) luminance of an (H, W, 3) BGR picture."""
    return np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY), dtype=np.uint8)


def block_means(grey: Grey) -> Blocks:
    """Mean over each block of 16x16 px of a (H, W) picture."""
    height, width = grey.shape
    size = (max(1, width // BLOCK_PX), max(1, height // BLOCK_PX))
    return np.asarray(cv2.resize(grey, size, interpolation=cv2.INTER_AREA).astype(np.float32))


def block_difference(a: Grey, b: Grey) -> Blocks:
    """Mean absolute difference of two (H, W) pictures over each block of 16x16 px, grey levels."""
    height, width = a.shape
    size = (max(1, width // BLOCK_PX), max(1, height // BLOCK_PX))
    change = cv2.absdiff(a, b).astype(np.float32)
    return np.asarray(cv2.resize(change, size, interpolation=cv2.INTER_AREA), np.float32)


@dataclass(frozen=True, eq=False)
class NoiseModel:
    """How much two pictures of the same still scene differ: a bright block more than a dark one.

    Attributes:
        levels: expected block difference at the brightness of each bin's middle, grey levels.
        spread: standard deviation of a block's difference as a share of what is expected.
        limit: standard deviations beyond which something has moved.

    """

    levels: NDArray[np.float64]
    spread: float
    limit: float

    @classmethod
    def of(cls, frames: Sequence[Grey]) -> Self:
        """Learn from neighbours among at least three frames of a still scene."""
        pairs = np.stack([block_difference(a, b) for a, b in itertools.pairwise(frames)])
        bins = (block_means(frames[0]) / _BIN_LEVELS).astype(int)
        seen = np.unique(bins)
        means = [max(float(pairs[:, bins == number].mean()), _QUIETEST_LEVELS) for number in seen]
        levels = np.interp(np.arange(256 // _BIN_LEVELS), seen, means)
        shares = pairs / levels[bins] - 1.0
        spread = max(float(np.sqrt(np.mean(shares**2))), _LEAST_SPREAD)
        return cls(levels, spread, max(_CHANGED, _TAIL_MARGIN * float(shares.max()) / spread))

    def change(self, a: Grey, b: Grey) -> float:
        """Standard deviations by which the most changed block of two pictures differs more than noise would."""
        brightness = np.maximum(block_means(a), block_means(b)) / _BIN_LEVELS - 0.5
        expected = np.interp(brightness, np.arange(len(self.levels)), self.levels)
        return float((block_difference(a, b) / expected - 1.0).max()) / self.spread

    def moved(self, a: Grey, b: Grey) -> bool:
        """Whether something moved between two pictures."""
        return self.change(a, b) > self.limit


class StillnessWatch:
    """Fed with the frames after a move, tells when the arm has come to rest.

    `reference` is the picture before the move; with None no onset is waited for. `onset_by_s` is when to give up on it,
    `earliest_s` the end of the commanded motion, both on the clock of the frames' arrival.
    """

    def __init__(
        self,
        noise: NoiseModel,
        still_s: float,
        earliest_s: float,
        reference: Grey | None = None,
        onset_by_s: float = 0.0,
    ) -> None:
        self._noise = noise
        self._still_s = still_s
        self._earliest_s = earliest_s
        self._reference = reference
        self._onset_by_s = onset_by_s
        self.onset_at_s: float | None = None  # arrival of the first picture that differs from the reference
        self._window: deque[tuple[float, Grey, bool]] = deque()  # arrival, picture, whether it differs

    def feed(self, frame: Grey, arrived_s: float) -> bool:
        """Take the next frame; True when the arm is still in it and has been for long enough."""
        differs = self._reference is None or self._noise.moved(self._reference, frame)
        if differs and self.onset_at_s is None:
            self.onset_at_s = arrived_s
        window = self._window
        window.append((arrived_s, frame, differs))
        # Against every frame of the window, not the last alone: a slow creep shows in none of the small steps.
        while len(window) > 1 and self._noise.moved(window[0][1], frame):
            window.popleft()
        while len(window) > MIN_FRAMES and arrived_s - window[1][0] >= self._still_s:
            window.popleft()
        rested = len(window) >= MIN_FRAMES and arrived_s - window[0][0] >= self._still_s
        # The pictures at rest have to differ from the one before the move, all of them: a flicker on the way does not
        # count, and noise passes for a change in one frame of some thousands, but not in four that follow one another.
        arrived = all(differs for _, _, differs in window) or arrived_s >= self._onset_by_s
        return rested and arrived_s >= self._earliest_s and arrived
