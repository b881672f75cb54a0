"""The cluster that a sweep runs on: processes of this machine, or a scheduler that exists."""

from __future__ import annotations

import logging
import os
from collections.abc import Iterator
from contextlib import contextmanager

import dask
from distributed import Client, LocalCluster

from armtwin.models.errors import InputError, JobError
from armtwin.scenarios.processes import one_thread_each
from armtwin.scenarios.sweeps.journal import code_digest

# What a worker of this machine may take: about twice what one was measured to (docs/explanation/sweeps.md).
WORKER_MEMORY = "400MiB"
_CONNECT_S = 20.0
# A worker holds one world at a time and nothing that could be put aside, so that a pause would last for ever; one that
# grows beyond its limit is started anew.
_SETTINGS = {
    "distributed.scheduler.allowed-failures": 3,
    "distributed.comm.timeouts.connect": "10s",
    "distributed.worker.memory.target": False,
    "distributed.worker.memory.spill": False,
    "distributed.worker.memory.pause": False,
}


def cores() -> int:
    """Return the number of cores that this process may use."""
    return len(os.sched_getaffinity(0))


@contextmanager
def cluster(address: str | None, workers: int | None) -> Iterator[Client]:
    """Yield a client of the scheduler at `address`, or of a cluster of this machine's own that ends with the block.

    Raises `InputError` for an address that nobody answers at, or whose workers run other code.
    """
    dask.config.set(_SETTINGS)
    for name in ("distributed", "distributed.worker", "distributed.nanny", "distributed.scheduler", "bokeh", "tornado"):
        logging.getLogger(name).setLevel(logging.CRITICAL)
    if address is not None:
        with connected(address) as client:
            _check_code(client, address)
            yield client
        return
    with (
        one_thread_each(),
        LocalCluster(
            n_workers=workers or cores(),
            threads_per_worker=1,
            processes=True,
            host="127.0.0.1",
            dashboard_address="127.0.0.1:0",
            memory_limit=WORKER_MEMORY,
            silence_logs=logging.CRITICAL,
        ) as local,
        Client(local) as client,
    ):
        yield client


@contextmanager
def connected(address: str) -> Iterator[Client]:
    """Yield a client of the scheduler at `address`; raises `InputError` where nobody answers."""
    try:
        client = Client(address, timeout=_CONNECT_S, set_as_default=False)
    except (OSError, TimeoutError, ValueError) as error:
        raise InputError(
            f"--scheduler {address}: no Dask scheduler answers ({type(error).__name__}); start one: dask scheduler"
        ) from None
    try:
        yield client
    finally:
        client.close(timeout=2.0)


def _check_code(client: Client, address: str) -> None:
    """Worlds of other code are not to be mixed with those of this one."""
    own = code_digest()
    try:
        told = client.run(code_digest)
    except ImportError as error:
        raise InputError(f"--scheduler {address}: its workers lack armtwin[sweep] ({error})") from None
    if not told:
        raise JobError(f"--scheduler {address}: has no workers; start some: dask worker {address} --nthreads 1")
    for worker, version in told.items():
        if version != own:
            raise InputError(f"--scheduler {address}: worker {worker} runs other armtwin code; install the same there")
