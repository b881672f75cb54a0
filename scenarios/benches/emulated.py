"""The emulated bench behind the one interface: the emulator starts when it is connected and ends when it is closed."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from typing import Self

import cv2
import numpy as np
from numpy.typing import NDArray

from armtwin.hardware.bench.bench_file import read_bench
from armtwin.hardware.bench.hardware_bench import HardwareBench
from armtwin.models.arm import Arm
from armtwin.models.bench import BenchDescription, Frame
from armtwin.models.errors import JobError
from armtwin.scenarios.emulated_bench import EmulatedBench, emulated_setup
from armtwin.scenarios.marker_finder import marker_finder

Array = NDArray[np.float64]

# A film of one command: its picture comes so long after it.
_LAST_PICTURE_S = 0.04
# In a longer pause a command is given again: the board lets the arm go after 2 s of silence.
_SPEAK_S = 1.0


class EmulatedHardwareBench:
    """Satisfies `armtwin.models.bench.Bench`; from the port upwards everything is the real bench's."""

    def __init__(self, speed: float = 1.0, arm: Arm | None = None) -> None:
        """Note the speed, times real time, and maybe another arm; raises `InputError` as `EmulatedBench` does."""
        self.emulator = EmulatedBench(speed=speed, arm=arm)
        self._setup = emulated_setup("/dev/null", "http://127.0.0.1/", arm)  # port and stream are not known before
        self._bench: HardwareBench | None = None

    @property
    def description(self) -> BenchDescription:
        """What the emulated bench's file says."""
        return replace(self._setup.description, kind="emulated", hangs_loads=True)

    @property
    def notes(self) -> tuple[str, ...]:
        """What the stream gave other than it was asked for."""
        return () if self._bench is None else self._bench.notes

    @property
    def detached(self) -> bool:
        """Whether the board has said that the servos are without pulses."""
        return self._bench is None or self._bench.detached

    @property
    def clock_origin_s(self) -> float | None:
        """Unix time at which it was connected."""
        return None if self._bench is None else self._bench.clock_origin_s

    def connect(self) -> None:
        """Start the emulator and open what it offers; raises `JobError` where it cannot be built or run."""
        self.emulator.start()
        try:
            setup = read_bench(self.emulator.bench_file)
            finder = marker_finder(setup.arm, setup.camera, setup.arm_plane_z_mm)
            self._bench = HardwareBench(setup, finder, self.emulator.hang)
            self._bench.connect()
        except BaseException:
            self.close()
            raise

    def hang(self, payload_kg: float) -> None:
        """Hang a mass at the simulated tip."""
        self._connected().hang(payload_kg)

    def move(self, q_cmd_rad: NDArray[np.float64]) -> None:
        """Move as the hardware bench does."""
        self._connected().move(q_cmd_rad)

    def capture(self) -> Frame:
        """Take a picture as the hardware bench does."""
        return self._connected().capture()

    def film(self, time_s: NDArray[np.float64], q_cmd: NDArray[np.float64]) -> Iterator[Frame]:
        """Film as the hardware bench does, on the emulated world's own clock: a busy machine only takes longer."""
        bench = self._connected()
        self.emulator.quicken()
        bench.begin_film(q_cmd)
        return self._filmed(bench, time_s - time_s[0], q_cmd)

    def _filmed(self, bench: HardwareBench, after_s: Array, q_cmd: Array) -> Iterator[Frame]:
        last_s = float(np.median(np.diff(after_s))) if len(after_s) > 1 else _LAST_PICTURE_S
        # What keeps the link alive would come at another moment of the world each time; commands do as well.
        with bench.link.quiet():
            begun_s = self.emulator.hold()
            try:
                for given_s, next_s, q in zip(
                    after_s, np.append(after_s[1:], after_s[-1] + last_s), q_cmd, strict=True
                ):
                    for until_s in (*np.arange(given_s + _SPEAK_S, next_s - _SPEAK_S / 2, _SPEAK_S), next_s):
                        seen_s, jpeg = self.emulator.step(begun_s + float(until_s), partial(bench.send, q))
                    image = cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR)
                    yield Frame(np.asarray(image, np.uint8), seen_s - begun_s, float(given_s))
            finally:
                self.emulator.release()

    def close(self) -> None:
        """Detach the servos and end the emulator; safe to call twice."""
        try:
            if self._bench is not None:
                self._bench.close()
        finally:
            self.emulator.close()

    def __enter__(self) -> Self:
        self.connect()
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def _connected(self) -> HardwareBench:
        if self._bench is None:
            raise JobError("the emulated bench is not connected; call connect() first")
        return self._bench
