"""What is kept of a sweep on a disk that is full, and of another sweep's."""

import resource
from pathlib import Path

import pytest

from armtwin.models.errors import InputError, JobError
from armtwin.scenarios.sweeps.journal import JOURNAL, Journal, read_rows

_STAMP = {"table": {"seed": 1}, "code": "abc"}


def _row(trial: int) -> dict[str, object]:
    return {"cell": 0, "trial": trial, "effect": "backlash", "cost": {}}


def test_a_full_disk_is_one_line_and_costs_no_world_that_was_finished(tmp_path: Path) -> None:
    journal = Journal(tmp_path, _STAMP)
    journal.add(_row(0))
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, ((tmp_path / JOURNAL).stat().st_size + 10, before[1]))
    try:
        with pytest.raises(JobError, match="the same command goes on from there"):
            journal.add(_row(1))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    again = Journal(tmp_path, _STAMP)
    assert list(again.rows) == [(0, 0)]
    again.add(_row(1))
    again.close()
    assert list(read_rows(tmp_path)) == [(0, 0), (0, 1)]


@pytest.mark.parametrize(("stamp", "what"), [({"table": {"seed": 2}}, "SWEEP.toml"), ({"code": "new"}, "code")])
def test_worlds_of_another_sweep_or_code_are_not_mixed_in(tmp_path: Path, stamp: dict[str, object], what: str) -> None:
    Journal(tmp_path, _STAMP).close()
    with pytest.raises(InputError, match=f"worlds of another {what}; choose another --out"):
        Journal(tmp_path, {**_STAMP, **stamp})
