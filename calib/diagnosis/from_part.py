"""What a part of the poses showed, as the beginning of a model of all of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from armtwin.calib.diagnosis.explanation import Explanation
from armtwin.calib.diagnosis.fit import Data, Fit, fit
from armtwin.calib.diagnosis.replacement import rescanned_all
from armtwin.models.catalogue.predict import Active
from armtwin.models.recordings.part import Part


def from_part(raw: Data, first: Explanation, part: Part) -> tuple[Data, Fit]:
    """Return the data with the noise that the part had, if it is not declared, and the model fitted to all rows.

    Rows at which something happened are known to within the gaps between the runs of the part: they are scanned anew.
    """
    if not raw.declared:
        raw = replace(raw, noise=max(first.data.noise, raw.problem.grain_std))
    raw = replace(raw, problem=raw.problem.with_links(first.final.g))
    effects = tuple(_of_all_rows(raw, first, active, part) for active in first.final.effects)
    return raw, rescanned_all(raw, fit(raw, first.final.g, effects))


def _of_all_rows(raw: Data, first: Explanation, active: Active, part: Part) -> Active:
    n = len(raw.problem.context)
    if active.effect.found is not None:  # a row each, maybe with a fraction that says which joints
        whole = np.floor(active.values)
        return replace(active, values=np.array([part.there(row, n) for row in whole]) + active.values - whole)
    values = active.values.copy()
    for k, one in enumerate(active.effect.parameters(first.data.problem.context, active.site)):
        if one.scanned and one.name.startswith("from_sample"):
            values[k] = part.there(values[k], n)
    return replace(active, values=values)
