"""A cause written out as data."""

from __future__ import annotations

import numpy as np

from armtwin.calib.diagnosis.diagnosis import NamedCause
from armtwin.models.catalogue.predict import Active
from armtwin.models.catalogue.registry import Site, effect_named
from armtwin.scenarios.diagnosis.causes import cause_table


def test_a_tie_keeps_its_marker() -> None:
    tilt = Active(effect_named("axis_tilt"), Site(joint=2), np.zeros(3))
    sticker = Active(effect_named("marker_offset"), Site(marker="b"), np.zeros(3))
    written = cause_table(NamedCause(tilt, (), np.zeros(0), 1e-9, 90.0, (sticker,)), {})
    assert (written["effect"], written["joint"], written["marker"]) == ("axis_tilt", 2, None)
    assert written["equivalents"] == [{"effect": "marker_offset", "joint": None, "marker": "b"}]
