"""Results in a notebook and as columns."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import armtwin
from armtwin.models.recordings.writer import columns_of
from armtwin.models.tabular import html_table
from tests.support.recordings import recording

pyarrow = pytest.importorskip("pyarrow")


def test_a_recording_gives_the_columns_of_its_file() -> None:
    made = recording()
    columns = made.columns()
    assert list(columns) == columns_of(made)
    assert pyarrow.table(columns).num_rows == len(made)


def test_calibration_and_diagnosis_give_a_row_a_parameter_and_show_it() -> None:
    found = armtwin.calibrate(recording())
    assert pyarrow.table(found.columns()).column("parameter").to_pylist() == list(found.names)
    assert found.names[0] in found._repr_html_()
    diagnosis = armtwin.diagnose(recording())
    assert pyarrow.table(diagnosis.columns()).num_rows == sum(len(cause.names) for cause in diagnosis.causes)
    assert "Diagnosis: none" in diagnosis._repr_html_()


def test_what_a_file_named_cannot_run_in_a_notebook() -> None:
    made = recording()
    named = replace(made, trajectory=np.full(len(made), "<script>alert(1)</script>"))
    assert "<script>" not in named._repr_html_()
    assert "&lt;script&gt;" in named._repr_html_()
    assert "… 20 rows" in html_table("t", {"a": list(range(20))})
