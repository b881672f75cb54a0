"""Waiting for the end of a motion in the picture of a stream that is late by an unknown time."""

from __future__ import annotations

import time
from dataclasses import dataclass

from armtwin.hardware.bench.tables import SettleTable
from armtwin.hardware.camera.stillness import Grey, NoiseModel, StillnessWatch, to_grey
from armtwin.hardware.camera.webcam import CameraLostError, Picture, Webcam
from armtwin.models.errors import JobError

# Pictures of the limp arm that the noise is taken from: half a second of a 25 Hz camera.
NOISE_PICTURES = 12
# In a scene that should be still, more than a sensor makes is a hand, flicker or a swinging arm: the largest change of
# a block in standard deviations, and that deviation as a share of the block's noise (0.05 to 0.2 for a sensor).
MAX_NOISE_LIMIT = 20.0
MAX_NOISE_SPREAD = 0.5
# A stream that was late before is waited for this many times as long before a move counts as not made.
_ONSET_MARGIN = 3.0


class MotionError(JobError):
    """The arm did not come to rest, or did not move."""


@dataclass(frozen=True, eq=False)
class Rest:
    """The picture of an arm at rest, the same in grey, and whether a motion showed before it."""

    picture: Picture
    grey: Grey
    moved: bool


class Settling:
    """Tells from a webcam's pictures when the arm has come to rest, and learns how late they are."""

    def __init__(self, webcam: Webcam, settle: SettleTable) -> None:
        self._webcam = webcam
        self._settle = settle
        self._noise: NoiseModel | None = None
        self._late_s = 0.0  # how far the stream is behind: from the last command until its motion began to show
        self._worst_late_s = 0.0  # the longest of these so far

    def learn_noise(self) -> None:
        """Learn the picture's noise from a scene that is still; raises `CameraLostError` if it does not become so."""
        greys: list[Grey] = []
        picture = self._webcam.newest()
        give_up_s = time.monotonic() + self._settle.timeout_s
        while True:
            picture = self._webcam.after(picture.number)
            greys = [*greys, to_grey(picture.image)][-NOISE_PICTURES:]
            if len(greys) < NOISE_PICTURES:
                continue
            noise = NoiseModel.of(greys)
            if noise.limit <= MAX_NOISE_LIMIT and noise.spread <= MAX_NOISE_SPREAD:
                self._noise = noise
                return
            if time.monotonic() > give_up_s:
                raise CameraLostError(
                    f"camera {self._webcam.source}: the picture is not quiet before the start (parts of it change by "
                    f"{noise.limit * noise.spread:.0f} times the noise); keep hands out, steady the light"
                )

    def now(self) -> Grey:
        """Return the newest picture, to be compared with what a command is about to change."""
        return to_grey(self._webcam.newest().image)

    def wait(self, before: Grey | None, sent_s: float) -> Rest:
        """Wait for the picture to rest after a command that was sent at `sent_s` and has been executed.

        `before` is the picture from before it; None where its motion need not show. Raises `JobError`.
        """
        if self._noise is None:
            raise JobError("the bench is not connected")
        ended_s = time.monotonic()
        onset_by_s = ended_s + max(self._settle.onset_s, _ONSET_MARGIN * self._worst_late_s)
        # What arrives before the stream can have caught up shows no end of this motion, whatever else changes in it.
        watch = StillnessWatch(self._noise, self._settle.still_s, ended_s + self._late_s, before, onset_by_s)
        give_up_s = onset_by_s + self._settle.timeout_s
        picture = first = self._webcam.newest()
        while not watch.feed(grey := to_grey(picture.image), picture.arrived_s):
            if time.monotonic() > give_up_s:
                raise MotionError(
                    f"the arm did not come to rest in the picture within {self._settle.timeout_s:g} s; look for a "
                    "swinging arm, a humming servo, flickering light or someone in the picture, or raise "
                    "settle.timeout_s"
                )
            picture = self._webcam.after(picture.number)
        if before is not None and watch.onset_at_s is not None:
            self._note_lateness(watch.onset_at_s - sent_s, watch.onset_at_s > first.arrived_s)
        return Rest(picture, grey, watch.onset_at_s is not None)

    def _note_lateness(self, late_s: float, was_seen: bool) -> None:
        """Note how late a motion began to show; where that was missed, the first picture says how late at most."""
        self._late_s = late_s if was_seen else min(late_s, self._late_s)
        self._worst_late_s = max(self._worst_late_s, self._late_s)
