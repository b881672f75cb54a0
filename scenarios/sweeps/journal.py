"""What is kept of a sweep: a line for every finished world, written as it finishes, and the tables made of them.

The journal is only ever added to, so that whatever ends a run leaves all but its last line whole; a line cut short is
cut off when the run goes on. The tables hold nothing that another run would have otherwise: what a world cost stands in
a table of its own.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

import armtwin.calib
import armtwin.models
import armtwin.scenarios.scoring
import armtwin.scenarios.sweeps
import armtwin.sim
from armtwin.models import atomic
from armtwin.models.errors import InputError, JobError
from armtwin.scenarios.sweeps.trial import Row

JOURNAL = "trials.jsonl"
RESULTS = "results.parquet"
COSTS = "costs.parquet"
SCHEMA = "armtwin.trials/1"

Key = tuple[int, int]

_VALUES = pa.list_(pa.struct([("name", pa.string()), ("value", pa.float64())]))
_INTERVALS = pa.list_(pa.struct([("name", pa.string()), ("value", pa.float64()), ("std", pa.float64())]))
COLUMNS = pa.schema(
    [
        ("cell", pa.int64()),
        ("trial", pa.int64()),
        ("effect", pa.string()),
        ("place", pa.string()),
        ("size", pa.float64()),
        ("noise_px", pa.float64()),
        ("poses", pa.int64()),
        ("plan", pa.string()),
        ("markers", pa.string()),
        ("noise_declared", pa.bool_()),
        ("rendered", pa.bool_()),
        ("hidden", pa.string()),
        ("hidden_parameters", _VALUES),
        ("verdict", pa.string()),
        ("said", pa.string()),
        ("said_where", pa.string()),
        ("found", pa.bool_()),
        ("wrong", pa.bool_()),
        ("tied", pa.int64()),
        ("misses", _VALUES),
        ("intervals", _INTERVALS),
        ("before_mm", pa.float64()),
        ("after_mm", pa.float64()),
        ("n_poses", pa.int64()),
        ("error", pa.string()),
    ]
)


def code_digest() -> str:
    """Return a digest of the code that draws, diagnoses and judges: worlds of other code are not to be mixed."""
    digest = hashlib.sha256()
    for package in (armtwin.models, armtwin.sim, armtwin.calib, armtwin.scenarios.scoring, armtwin.scenarios.sweeps):
        root = Path(package.__path__[0])
        for path in sorted(root.rglob("*.py")):
            digest.update(path.relative_to(root).as_posix().encode())
            digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


class Journal:
    """The journal in a sweep's folder, opened by its one writer; `rows` holds what is in it, by (cell, trial)."""

    def __init__(self, folder: Path, stamp: Mapping[str, Any]) -> None:
        self._path = folder / JOURNAL
        self.rows: dict[Key, Row] = {}
        head = {"schema": SCHEMA, **stamp}
        if self._path.exists():
            self._go_on(head)
            self._file = self._path.open("ab")
        else:
            self._file = self._path.open("ab")
            self._write(head)

    def add(self, row: Row) -> None:
        """Keep a world's row; raises `JobError` where the disk takes no more."""
        self._write(row)
        self.rows[row["cell"], row["trial"]] = row

    def close(self) -> None:
        """Give the file back."""
        self._file.close()

    def _write(self, line: Mapping[str, Any]) -> None:
        try:
            self._file.write(json.dumps(line, allow_nan=False, separators=(",", ":")).encode() + b"\n")
            self._file.flush()
        except OSError as error:
            raise JobError(
                f"{self._path}: {error.strerror}; what is finished is kept, the same command goes on from there"
            ) from None

    def _go_on(self, head: Mapping[str, Any]) -> None:
        """Read what is there, cut off a line that was not finished, and refuse the journal of another sweep."""
        data = self._path.read_bytes()
        whole = data[: data.rfind(b"\n") + 1]
        try:
            lines = [json.loads(line) for line in whole.splitlines()]
        except ValueError:
            raise InputError(f"{self._path}: holds lines that are no JSON; choose another --out") from None
        if lines and lines[0] != head:
            said = "code" if lines[0].get("table") == head.get("table") else "SWEEP.toml"
            raise InputError(f"{self._path}: holds worlds of another {said}; choose another --out")
        if len(whole) < len(data):
            os.truncate(self._path, len(whole))
        if not lines:
            self._path.unlink()
            atomic.write_bytes(self._path, json.dumps(head, separators=(",", ":")).encode() + b"\n")
        self.rows = {(row["cell"], row["trial"]): row for row in lines[1:]}


def read_rows(folder: Path) -> dict[Key, Row]:
    """Return the rows of a sweep's folder by (cell, trial); raises `InputError` where it is none."""
    path = folder / JOURNAL
    if not path.is_file():
        raise InputError(f"{folder}: holds no {JOURNAL}; run armtwin sweep there first")
    lines = [json.loads(line) for line in path.read_bytes().splitlines(keepends=True) if line.endswith(b"\n")]
    return {(row["cell"], row["trial"]): row for row in lines[1:]}


def write_tables(folder: Path, rows: Mapping[Key, Row]) -> None:
    """Write results and costs as parquet, in the order of cells and trials."""
    ordered = [rows[key] for key in sorted(rows)]
    results = pa.Table.from_pylist([{name: row.get(name) for name in COLUMNS.names} for row in ordered], COLUMNS)
    costs = pa.table(
        {
            "cell": [row["cell"] for row in ordered],
            "trial": [row["trial"] for row in ordered],
            "draw_s": [row["cost"].get("draw_s") for row in ordered],
            "diagnose_s": [row["cost"].get("diagnose_s") for row in ordered],
        }
    )
    for name, table in ((RESULTS, results), (COSTS, costs)):
        sink = pa.BufferOutputStream()
        pq.write_table(table, sink, compression="zstd")
        atomic.write_bytes(folder / name, sink.getvalue().to_pybytes())
