"""Time from sending a move to its acknowledgement, in the emulator at real-time speed; the bench allows 20 ms (median).

python tests/benchmarks/bench_link.py --moves 500
"""

from __future__ import annotations

import argparse
import time

import numpy as np

from armtwin.hardware.emulator import FirmwareEmulator
from armtwin.hardware.link.servo_link import ServoLink


def acknowledgement_s(moves: int, seed: int) -> np.ndarray:
    """Seconds that each of `moves` moves took to be acknowledged, shape (moves,)."""
    pulses_us = np.random.default_rng(seed).uniform(1400.0, 1600.0, (moves, 3))
    times_s = np.empty(moves)
    with FirmwareEmulator() as board, ServoLink(board.port) as link:
        link.arm([1500.0, 1500.0, 1500.0])
        for move in range(moves):
            start = time.perf_counter()
            link.move(pulses_us[move], 0.1)
            times_s[move] = time.perf_counter() - start
    return times_s


def main() -> None:
    """Print median, 95th percentile and maximum in ms."""
    parser = argparse.ArgumentParser(description="Time to the acknowledgement of a move, in the emulator.")
    parser.add_argument("--moves", type=int, default=500)
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    times_ms = acknowledgement_s(arguments.moves, arguments.seed) * 1e3
    median, high = np.percentile(times_ms, [50, 95])
    print(f"{arguments.moves} moves: median {median:.2f} ms, 95 % {high:.2f} ms, longest {times_ms.max():.2f} ms")


if __name__ == "__main__":
    main()
