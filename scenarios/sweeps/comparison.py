"""`power`'s predictions held against a sweep's trials: where they disagree, by how much, and why."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

from armtwin.scenarios.power.place import PlacePower
from armtwin.scenarios.power.power import over_places, power
from armtwin.scenarios.power.setting import Setting
from armtwin.scenarios.sweeps.curve import Found, wilson
from armtwin.scenarios.sweeps.shift import predicted_over_found
from armtwin.scenarios.sweeps.summary import CellSummary
from armtwin.scenarios.sweeps.table import DRAWN, place_of
from armtwin.scenarios.sweeps.trial import plan_of_cell

# By more than this factor a prediction disagrees.
FACTOR = 1.3


@dataclass(frozen=True, eq=False)
class Held:
    """One cell's prediction and trials.

    Attributes:
        summary, places: the trials; what power says of each place of the cell.
        predicted: size found in 90 of 100; None where none is. For a fault of one size the share found.
        measured, low, high: the same of the trials, with its interval of 90 %.
        off: how many times too large the predicted curves are, by all trials; None for a fault of one size.

    """

    summary: CellSummary
    places: tuple[PlacePower, ...]
    predicted: float | None
    measured: float | None
    low: float | None
    high: float | None
    off: Found | None = None

    @property
    def ratio(self) -> float | None:
        """Predicted over measured, by the whole curve where there is one."""
        if self.off is not None and self.off.size is not None:
            return self.off.size
        return self.predicted / self.measured if self.predicted and self.measured else None

    @property
    def agrees(self) -> bool:
        """Whether both are within the factor, or both say that no size is found so often."""
        if self.ratio is None:
            return self.predicted is None and self.measured is None
        return 1.0 / FACTOR <= self.ratio <= FACTOR

    @property
    def within_interval(self) -> bool:
        """Whether the prediction lies where the trials leave it."""
        if self.predicted is None:
            return self.high is None
        return (self.low or 0.0) <= self.predicted and (self.high is None or self.predicted <= self.high)


def hold(
    cells: Sequence[CellSummary], jobs: int, progress: Callable[[int, int], None] = lambda done, total: None
) -> list[Held]:
    """Predict every cell that has a plan of its own and one effect, and hold the trials against it."""
    wanted = [one for one in cells if one.cell.plan != DRAWN and len(one.cell.effects) == 1]
    settings = {_key(one): None for one in wanted}
    out: list[Held] = []
    for number, key in enumerate(settings):
        of_setting = [one for one in wanted if _key(one) == key]
        plan = plan_of_cell(of_setting[0].cell)
        assert plan is not None
        setting = Setting(plan, of_setting[0].cell.noise_px, tuple(of_setting[0].cell.markers))
        names = list(dict.fromkeys(one.cell.effects[0] for one in of_setting))
        told = power(setting, effects=names, jobs=jobs, progress=progress)
        out += [_held(one, told.of(one.cell.effects[0])) for one in of_setting]
        progress(number + 1, len(settings))
    return out


def _held(one: CellSummary, places: Iterable[PlacePower]) -> Held:
    place = place_of(one.cell.place)
    mine = tuple(p for p in places if place is None or p.site == place)
    if one.curve is None:
        hits, of = one.share
        low, high = wilson(hits, of)
        shares = [p.share for p in mine if p.fixed]
        predicted = sum(shares) / len(shares) if shares else None
        return Held(one, mine, predicted, hits / of if of else None, low, high)
    return Held(one, mine, over_places(mine, 0.9), *_interval(one.ninety), predicted_over_found(one.rows, mine))


def _interval(found: Found) -> tuple[float | None, float | None, float | None]:
    return found.size, found.low, found.high


def _key(one: CellSummary) -> tuple[str, int, float, str]:
    return one.cell.plan, one.cell.poses, one.cell.noise_px, one.cell.markers
