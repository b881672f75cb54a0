"""How far a predicted curve is off trials whose truth is known."""

import numpy as np
import pytest

from armtwin.models.catalogue.site import Site
from armtwin.scenarios.power.place import PlacePower
from armtwin.scenarios.sweeps.shift import predicted_over_found

_SIZES = (1.0, 1.5, 2.0, 3.0)
_FOUND = (0.0, 0.5, 0.9, 1.0)


def _place(joint: int, times: float) -> PlacePower:
    return PlacePower("backlash", Site(joint), "rad", tuple(times * s for s in _SIZES), _FOUND)


def _rows(joint: int, n: int) -> list[dict[str, object]]:
    rng = np.random.default_rng(joint)
    sizes = np.exp(rng.uniform(np.log(0.5), np.log(6.0), n))
    found = rng.random(n) < np.interp(np.log(sizes), np.log(_SIZES), _FOUND)
    return [{"hidden": f"backlash {joint}", "size": s, "found": bool(f)} for s, f in zip(sizes, found, strict=True)]


def test_a_curve_that_is_right_is_told_to_be_right() -> None:
    off = predicted_over_found(_rows(1, 60), [_place(1, 1.0)])
    assert off is not None
    assert off.size == pytest.approx(1.0, rel=0.15)
    assert off.low is not None
    assert off.high is not None
    assert off.low < 1.0 < off.high


def test_sizes_predicted_twice_too_large_are_told_so_with_every_place_by_its_own_curve() -> None:
    off = predicted_over_found([*_rows(1, 60), *_rows(2, 60)], [_place(1, 2.0), _place(2, 2.0)])
    assert off is not None
    assert off.size == pytest.approx(2.0, rel=0.15)


def test_without_a_curve_nothing_is_told() -> None:
    assert predicted_over_found(_rows(1, 5), []) is None
