"""The one door to every bench.

with open_bench("simulated") as bench:
    bench.move(q_cmd_rad)
    frame = bench.capture()
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from armtwin.hardware.bench.bench_file import BenchSetup, read_bench
from armtwin.hardware.bench.hardware_bench import HardwareBench
from armtwin.models.bench import Bench
from armtwin.models.errors import InputError, JobError
from armtwin.scenarios.benches.emulated import EmulatedHardwareBench
from armtwin.scenarios.benches.simulated import simulated_bench
from armtwin.scenarios.benches.spec import BenchSpec, EmulatedSpec, HardwareSpec, RemoteSpec, SimulatedSpec, bench_spec
from armtwin.scenarios.emulated_bench import EmulatedBench
from armtwin.scenarios.marker_finder import marker_finder


@dataclass(frozen=True)
class Session:
    """What a bench is opened for, which only a simulated one needs to know.

    Attributes:
        purpose: names the random numbers of its sensor's noise: the same for the same purpose.
        n_poses: how many poses are to come, which a creeping camera goes by; None where nobody knows.
        samples_before: how many the bench has run earlier: what happens at some sample has then happened.

    """

    purpose: str = "capture"
    n_poses: int | None = None
    samples_before: int = 0


def open_bench(
    bench: BenchSpec | str, session: Session = Session(), hang_by: Callable[[float], None] | None = None
) -> Bench:
    """Return a bench, not yet connected: a context manager that connects it and closes it.

    `bench` is what `bench_spec` takes or returns. `hang_by` hangs a mass of so many kg at the tip of a hardware bench,
    or asks someone to; the simulated ones do it themselves. Raises `InputError`.
    """
    match bench_spec(bench) if isinstance(bench, str) else bench:
        case SimulatedSpec(scenario):
            return simulated_bench(scenario, session.purpose, session.n_poses, session.samples_before)
        case EmulatedSpec(speed, arm):
            return EmulatedHardwareBench(speed, arm)
        case HardwareSpec(setup):
            return HardwareBench(setup, marker_finder(setup.arm, setup.camera, setup.arm_plane_z_mm), hang_by)
        case RemoteSpec(url, token):
            try:
                from armtwin.scenarios.serving.remote import RemoteBench  # needs the extra `serve`
            except ModuleNotFoundError as error:
                raise JobError(f"{url}: {error.name} is not installed; install armtwin[serve]") from None
            return RemoteBench(url, token)


@contextmanager
def bench_setup(said: str) -> Iterator[BenchSetup]:
    """Yield the setup of a hardware bench, or of the emulated one while it runs; raises `InputError` for others."""
    match bench_spec(said):
        case HardwareSpec(setup):
            yield setup
        case EmulatedSpec(speed, arm):
            with EmulatedBench(speed=speed, arm=arm) as emulated:
                yield read_bench(emulated.bench_file)
        case _:
            wanted = "a bench file (TOML) or 'emulated' is wanted"
            raise InputError(f"--bench: '{said[:80]}' has no wires to look at; {wanted}")
