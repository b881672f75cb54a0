"""Pulses of six servos in the emulator: is each as long as asked to the processor's cycle, the line idle or full?

python tests/benchmarks/bench_pulses.py --widths 161
"""

from __future__ import annotations

import argparse

import numpy as np

from armtwin.hardware.emulator import FirmwareEmulator
from armtwin.hardware.emulator.fuzz import catch_up, greeted
from armtwin.hardware.link import messages
from armtwin.hardware.link.framing import encode
from armtwin.hardware.link.messages import MOST_SERVOS, TICKS_PER_US, Request

SHORTEST, LONGEST = 500 * TICKS_PER_US, 2500 * TICKS_PER_US  # ticks
CYCLE_US = 1 / 16
BYTE_S = 10 / 115200
SECONDS = 0.4  # of pulses for each set of widths
PATIENCE_S = 10.0  # real time


def sets_of_ticks(n: int) -> np.ndarray:
    """(n, 6) widths that run through the whole range on every servo, each servo elsewhere in it."""
    span = LONGEST - SHORTEST + 1
    first = np.linspace(0.0, LONGEST - SHORTEST, n).round().astype(int)[:, None]
    return SHORTEST + (first + span // MOST_SERVOS * np.arange(MOST_SERVOS)) % span


def pulses_off(ticks: np.ndarray, busy: bool, seed: int) -> tuple[int, int, float]:
    """Return how many pulses were seen, how many of them were off, and the least time from one to the next, us."""
    seen = off = 0
    gap_us = np.inf
    question = encode(messages.request(Request.STATE, 1))
    with FirmwareEmulator(speed=4.0) as board, greeted(board, seed) as line:
        line.port.write_timeout = PATIENCE_S
        for wanted in ticks.tolist():
            line.ask(Request.ARM, messages.widths_body(wanted))
            if busy:
                line.port.write(question * round(SECONDS / BYTE_S / len(question)))
                catch_up(line.port, 2)
            end_s = board.time_s + SECONDS
            board.wait_until(lambda end_s=end_s: board.time_s >= end_s, PATIENCE_S)
            line.ask(Request.DETACH)
            board.wait_until(lambda: bool(np.isnan(board.widths_us()).all()), PATIENCE_S)
            pulses = board.drain()
            seen += len(pulses)
            off += sum(abs(pulse.width_us - wanted[pulse.servo] / TICKS_PER_US) >= CYCLE_US for pulse in pulses)
            ends, widths = (np.array([(p.time_s * 1e6, p.width_us) for p in pulses])).T
            gap_us = min(gap_us, float((ends[1:] - widths[1:] - ends[:-1]).min()))
    return seen, off, gap_us


def main() -> None:
    """Print one line for the idle and one for the full line."""
    parser = argparse.ArgumentParser(description="Widths of the pulses of six servos, in the emulator.")
    parser.add_argument("--widths", type=int, default=161)
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    for busy in (False, True):
        seen, off, gap_us = pulses_off(sets_of_ticks(arguments.widths), busy, arguments.seed)
        line = "full" if busy else "idle"
        print(
            f"line {line}: {seen} pulses, {off} off by a cycle or more; at least {gap_us:.0f} us from one to the next"
        )


if __name__ == "__main__":
    main()
