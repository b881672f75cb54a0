"""What a sweep's rows add up to, and its page, from rows of which the truth is known."""

from collections.abc import Mapping

import numpy as np
import pytest

from armtwin.models.catalogue.site import Site
from armtwin.scenarios.power.place import PlacePower
from armtwin.scenarios.sweeps.comparison import Held
from armtwin.scenarios.sweeps.page import sweep_page
from armtwin.scenarios.sweeps.placing import Placing
from armtwin.scenarios.sweeps.summary import CellSummary, confusion, coverage, sizes_table, summaries
from armtwin.scenarios.sweeps.table import SweepTable, cells_of
from armtwin.scenarios.sweeps.trial import Row

_TRUE = 0.002
Swept = tuple[list[CellSummary], Mapping[tuple[int, int], Row]]


def _row(cell: int, trial: int, size: float) -> Row:
    found = size > _TRUE
    return {
        "cell": cell,
        "trial": trial,
        "size": size,
        "found": found,
        "said": "backlash" if found else "none",
        "misses": [{"name": "backlash.width_rad", "value": 0.5 if trial % 4 else 3.0}] if found else [],
        "cost": {"draw_s": 0.2, "diagnose_s": 0.9},
    }


@pytest.fixture(scope="module")
def swept() -> Swept:
    table = SweepTable.model_validate(
        {
            "schema": "armtwin.sweep/1",
            "trials": 40,
            "confirm": 4,
            "factors": {"effects": ["backlash"], "noise_px": [0.05, 0.1]},
        }
    )
    rows: dict[tuple[int, int], Row] = {}
    placings = [Placing(table, cell) for cell in cells_of(table)]
    for placing in placings:
        while trials := placing.next_round(rows):
            rows |= {trial.key: _row(*trial.key, trial.size) for trial in trials}
    return summaries(placings, rows, table.trials), rows


def test_worlds_are_placed_where_the_answer_changes(
    swept: Swept,
) -> None:
    cells, rows = swept
    assert len(rows) == 2 * 44
    late = [row["size"] for row in rows.values() if row["trial"] >= 20]
    assert np.median(np.abs(np.log(np.array(late) / _TRUE))) < 0.3
    for one in cells:
        assert one.half.size == pytest.approx(_TRUE, rel=0.15)
        assert one.ninety.size is not None
        assert one.confirmed == (4, 4)


def test_what_is_said_and_how_well_is_counted(swept: Swept) -> None:
    cells, rows = swept
    assert set(confusion(cells, large=True)["backlash"]) == {"backlash"}
    assert "none" in confusion(cells, large=False)["backlash"]
    inside, of = coverage(cells)["backlash.width_rad"]
    assert inside / of == pytest.approx(0.75, abs=0.15)
    table = sizes_table(cells, rows)
    assert [one["noise_px"] for one in table["cells"]] == [0.05, 0.1]


def test_the_page_says_where_power_disagrees(swept: Swept) -> None:
    cells, rows = swept
    place = PlacePower(
        "backlash", Site(1), "rad", sizes=(1e-3, 3e-3), found=(0.0, 1.0), low=(0.0, 1.0), high=(0.1, 1.0)
    )
    held = [
        Held(one, (place,), predicted, one.ninety.size, one.ninety.low, one.ninety.high)
        for one, predicted in zip(cells, (_TRUE, 3 * _TRUE), strict=True)
    ]
    assert [one.agrees for one in held] == [True, False]
    html = sweep_page("a sweep", cells, held, rows)
    assert "1 of 2" in html
    assert "NO" in html
