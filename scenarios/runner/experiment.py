"""A scenario's whole run in a folder, gone on with where it was killed."""

from __future__ import annotations

from pathlib import Path

from armtwin.models.errors import InputError
from armtwin.scenarios.benches.door import open_bench
from armtwin.scenarios.benches.spec import SimulatedSpec
from armtwin.scenarios.commands.outputs import check_out_folder
from armtwin.scenarios.runner.job import Job, locked, open_job
from armtwin.scenarios.runner.run import run_stages
from armtwin.scenarios.runner.stages import STAGES
from armtwin.scenarios.scenario import read_scenario


def run_experiment(scenario: str, out: Path, workers: int = 2, *, quiet: bool = False) -> Job:
    """Do what is not done yet of a scenario, by name or file, in the folder `out`.

    Raises `InputError` for a scenario or a folder that cannot be used, `JobError` where a stage fails.
    """
    wanted = read_scenario(scenario)
    check_out_folder(out)
    try:
        open_bench(SimulatedSpec(wanted))  # what cannot be filmed is refused before anything is written
    except InputError as error:
        raise InputError(f"{scenario}: {error}") from None
    job = open_job(out, wanted)
    with locked(job):
        run_stages(job, STAGES, workers, quiet=quiet)
    return job
