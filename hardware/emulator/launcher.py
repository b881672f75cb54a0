"""Starts the emulated board, hears its pulses and does to it what happens to a real one: reset, unplugged, powered off.

The C host (`host.c`) writes one line an event on its standard output, times in processor cycles of 1/16 us:

    port /dev/pts/5          the pseudo-terminal, again after each `plug`
    pulse 123456 9 24000     a pulse ended at this cycle on this Arduino pin, so many cycles long
    time 160000              every 10 ms of emulated time, pulses or none
    reset 160123             the processor was reset
    held 320000              emulated time has come to where `until` holds it
    heard                    bytes wait for the board, which stands there

and takes `reset`, `pause`, `resume`, `until CYCLE` (0: no end), `unplug`, `plug` on its standard input; it ends when
that closes, so it never outlives the program that started it.
"""

from __future__ import annotations

import contextlib
import subprocess
import tempfile
import threading
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from armtwin.hardware.emulator.build import Built, build
from armtwin.models.errors import JobError

CLOCK_HZ = 16e6  # the Uno's crystal
SERVO_PINS = (9, 10, 11, 5, 6, 7)  # Arduino numbers, as in servos.h; servo 1 to 6
PULSE_LOST_S = 0.05  # two and a half periods of 20 ms: a pin without a pulse for so long is no longer driven
BACKLOG = 20_000  # pulses kept for a reader; over a minute of six servos
START_TIMEOUT_S = 10.0


@dataclass(frozen=True)
class Pulse:
    """One pulse, as it stood on the pin: `time_s` its end in emulated time, `servo` 0 to 5, `width_us` its length."""

    time_s: float
    servo: int
    width_us: float


class FirmwareEmulator:
    """An Uno with the bench's firmware, its serial port at `port`; use as a context manager.

    Opening the port resets it, unless it is open already, as the Uno's USB chip does. Emulated time runs at `speed`
    times real time and falls behind, never jumps, if the machine is busy; at more than about 4 the firmware's 2 s of
    silence pass faster than a host may answer. `boot_delay_s` (emulated) is the boot loader: the board is deaf so long.
    Needs the packages named by `missing_packages()`; `start` raises JobError, with the command that installs them.
    """

    def __init__(self, *, speed: float = 1.0, boot_delay_s: float = 0.1) -> None:
        if not 0.0 < speed <= 100.0:
            raise ValueError(f"speed {speed} is not between 0 and 100")
        self._speed = speed
        self._boot_delay_s = boot_delay_s
        self._changed = threading.Condition()
        self._pulses: deque[Pulse] = deque(maxlen=BACKLOG)
        self._last: dict[int, Pulse] = {}
        self._time_s = 0.0
        self._resets = 0
        self._held = self._heard = False
        self._ended = True
        self._plugged = False
        self._process: subprocess.Popen[str] | None = None
        self._thread: threading.Thread | None = None
        self._folder: tempfile.TemporaryDirectory[str] | None = None

    def start(self) -> None:
        """Build what is not built yet, power the board and return when its port is there. Raises JobError."""
        built = build()
        self._folder = tempfile.TemporaryDirectory(prefix="armtwin-uno-")
        self._ended = False
        self._process = subprocess.Popen(  # noqa: S603 (our own program)
            self._command(built), stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1
        )
        self._thread = threading.Thread(target=self._listen, name="firmware-emulator", daemon=True)
        self._thread.start()
        if not self.wait_until(lambda: self._plugged or self._ended, START_TIMEOUT_S) or self._ended:
            self.close()
            raise JobError("the firmware emulator did not start; its message stands above")

    def close(self) -> None:
        """Power off and forget the port. May be called twice."""
        if self._process is not None:
            self._process.kill()  # it holds nothing worth saving
            self._process.wait()
            if self._thread is not None:
                self._thread.join()
            for stream in (self._process.stdin, self._process.stdout):
                if stream is not None:
                    with contextlib.suppress(BrokenPipeError):
                        stream.close()
            self._process = None
        if self._folder is not None:
            self._folder.cleanup()
            self._folder = None

    def __enter__(self) -> FirmwareEmulator:
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def port(self) -> str:
        """Path of the serial port; the same after `unplug` and `plug`, absent in between."""
        if self._folder is None:
            raise JobError("the firmware emulator is not running")
        return str(Path(self._folder.name) / "ttyACM0")

    @property
    def time_s(self) -> float:
        """Emulated time since power on, to 10 ms."""
        with self._changed:
            return self._time_s

    @property
    def resets(self) -> int:
        """How often the processor was reset since power on: by `reset` or by opening the port."""
        with self._changed:
            return self._resets

    def widths_us(self) -> NDArray[np.float64]:
        """Width of the pulses on each servo pin now, shape (6,); NaN for a pin without pulses (a limp servo)."""
        with self._changed:
            widths = np.full(len(SERVO_PINS), np.nan)
            for servo, pulse in self._last.items():
                if self._time_s - pulse.time_s < PULSE_LOST_S:
                    widths[servo] = pulse.width_us
            return widths

    def drain(self) -> list[Pulse]:
        """Pulses since the last call of `drain` or item of `pulses`, oldest first, without waiting."""
        with self._changed:
            pulses = list(self._pulses)
            self._pulses.clear()
            return pulses

    def pulses(self, timeout_s: float) -> Iterator[Pulse]:
        """Pulses as they come; ends when none came for `timeout_s` (real time) or the board is powered off."""
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._pulses or self._ended, timeout_s)
                if not self._pulses:
                    return
                pulse = self._pulses.popleft()
            yield pulse

    def wait_until(self, condition: Callable[[], bool], timeout_s: float) -> bool:
        """Wait until `condition` holds, looked at after every event of the board; False after `timeout_s` of real time.

        `condition` may use every property and `widths_us` of this object.
        """
        with self._changed:
            return self._changed.wait_for(condition, timeout_s)

    def reset(self) -> None:
        """Press the reset button."""
        self._tell("reset")

    def pause(self) -> None:
        """Stop emulated time: the board is deaf and mute and its pins keep their level."""
        self._tell("pause")

    def resume(self) -> None:
        """Let emulated time run again."""
        self._tell("resume")

    def run_until(self, time_s: float) -> None:
        """Let emulated time run until `time_s`, where it stands until the next call, and wait for that.

        What happens until then is independent of how busy the machine is. Raises JobError where it does not come there.
        """
        self._hold_at(round(time_s * CLOCK_HZ))
        if not self.wait_until(lambda: self._held or self._ended, START_TIMEOUT_S) or self._ended:
            raise JobError("the emulated board did not go on; the machine is too busy, or it has ended")

    def wait_for_bytes(self) -> None:
        """Wait, emulated time held by `run_until`, until bytes wait for the board; they are heard when it goes on."""
        if not self.wait_until(lambda: self._heard or self._ended, START_TIMEOUT_S) or self._ended:
            raise JobError("nothing was sent to the emulated board")

    def run_free(self) -> None:
        """Let emulated time run on, in step with real time."""
        self._hold_at(0)

    def _hold_at(self, cycle: int) -> None:
        with self._changed:
            self._held = self._heard = False
        self._tell(f"until {cycle}")

    def unplug(self) -> None:
        """Pull the data line out: the port vanishes under whoever has it open; the board keeps its power."""
        self._tell("unplug")
        self.wait_until(lambda: not self._plugged or self._ended, START_TIMEOUT_S)

    def plug(self) -> None:
        """Put the data line back: the port is there again under its old name."""
        self._tell("plug")
        self.wait_until(lambda: self._plugged or self._ended, START_TIMEOUT_S)

    def kill(self) -> None:
        """Cut the power: no more pulses, the port vanishes."""
        if self._process is not None:
            self._process.kill()
            self._process.wait()

    def _command(self, built: Built) -> list[str]:
        return [str(built.host), str(built.firmware), str(self._speed), str(self._boot_delay_s)]

    def _tell(self, command: str) -> None:
        if self._process is None or self._process.stdin is None:
            raise JobError("the firmware emulator is not running")
        try:
            self._process.stdin.write(command + "\n")
            self._process.stdin.flush()
        except BrokenPipeError:
            raise JobError("the firmware emulator has ended") from None

    def _listen(self) -> None:
        process = self._process
        if process is None or process.stdout is None:
            return
        for line in process.stdout:
            with self._changed:
                self._note(line.split())
                self._changed.notify_all()
        with self._changed:
            self._ended, self._plugged = True, False
            self._changed.notify_all()

    def _note(self, words: list[str]) -> None:
        match words:
            case ["pulse", cycle, pin, width]:
                self._time_s = int(cycle) / CLOCK_HZ
                servo = SERVO_PINS.index(int(pin))
                pulse = Pulse(self._time_s, servo, int(width) / CLOCK_HZ * 1e6)
                self._last[servo] = pulse
                self._pulses.append(pulse)
            case ["time", cycle]:
                self._time_s = int(cycle) / CLOCK_HZ
            case ["held", cycle]:
                self._time_s = int(cycle) / CLOCK_HZ
                self._held = True
            case ["heard"]:
                self._heard = True
            case ["reset", _]:
                self._resets += 1
            case ["port", device]:
                Path(self.port).symlink_to(device)
                self._plugged = True
            case ["unplugged"]:
                Path(self.port).unlink(missing_ok=True)
                self._plugged = False
