"""The page of a sweep."""

from __future__ import annotations

from collections.abc import Sequence

from armtwin.scenarios.power.words import amount
from armtwin.scenarios.report.page import page
from armtwin.scenarios.report.section import Section, plot, plots, prose, table
from armtwin.scenarios.sweeps.comparison import FACTOR, Held
from armtwin.scenarios.sweeps.curve import Found
from armtwin.scenarios.sweeps.figures import confusion_map, found_curve, size_map, title_of
from armtwin.scenarios.sweeps.summary import CellSummary, Rows, confusion, cost, coverage

# Curves beyond these would make a page that no browser likes to open; the parquet file holds all.
_MOST_CURVES = 60


def sweep_page(title: str, cells: Sequence[CellSummary], held: Sequence[Held], rows: Rows) -> str:
    """Return the report's HTML."""
    spent = cost(rows)
    placed = [one for one in cells if one.curve is not None]
    found = [one for one in placed if one.ninety.size is not None]
    answers = [
        (f"{len(rows)}", "worlds drawn, diagnosed and judged"),
        (f"{len(found)} of {len(placed)}", "cells with a size that is found in 90 of 100"),
        ("–" if spent["median_s"] is None else f"{spent['median_s']:.2f} s", "of processor a world, the median"),
    ]
    if held:
        answers.append((f"{sum(h.agrees for h in held)} of {len(held)}", f"predicted by power within {FACTOR:g}"))
    sections = [_sizes(cells), _curves(placed, held)]
    if len({(one.cell.noise_px, one.cell.poses) for one in cells}) > 1:
        sections.append(_map(placed))
    sections += [_confusion(cells), _coverage(cells)]
    if held:
        sections.insert(1, _held(held))
    about = "Worlds with hidden faults, each from its own seed, and what the diagnosis says of them."
    return page(title, about, answers, sections, key=("extended", "geometry") if held else ("extended",))


def _sizes(cells: Sequence[CellSummary]) -> Section:
    rows = [
        (
            title_of(one),
            _interval(one.half, one.unit),
            _interval(one.ninety, one.unit),
            f"{one.share[0]} of {one.share[1]}" if one.curve is None else "",
            f"{one.confirmed[0]} of {one.confirmed[1]}" if one.confirmed[1] else "–",
        )
        for one in cells
    ]
    header = ("fault", "found in 50 of 100 from", "in 90 of 100 from", "found as it is", "confirmed")
    note = "Intervals hold 90 % of what the trials leave open; 'no size' is a fault that is missed however large."
    return Section("sizes", "How large must a fault be?", note, (table(header, rows, "Sizes found", marked=(2,)),))


def _curves(placed: Sequence[CellSummary], held: Sequence[Held]) -> Section:
    predicted = {id(h.summary): [p for p in h.places if p.sizes and not p.why_not] for h in held}
    figures = [found_curve(one, predicted.get(id(one), ())) for one in placed[:_MOST_CURVES] if one.rows]
    caption = "Dots: neighbouring trials; line and band: the fitted curve and 90 % of what they leave open"
    caption += "; dashed: power, before any trial, and its range over the forms of the fault." if held else "."
    return Section(
        "curves",
        "Found, against size",
        "Where a curve stays below its top some faults are missed however large.",
        (plots(figures, caption),) if figures else (),
    )


def _map(placed: Sequence[CellSummary]) -> Section:
    groups: dict[str, list[CellSummary]] = {}
    for one in placed:
        groups.setdefault(one.cell.effect, []).append(one)
    figures = [size_map(group) for group in groups.values() if any(one.ninety.size is not None for one in group)]
    return Section(
        "map",
        "Against noise and poses",
        "The size found in 90 of 100 recordings, with what the trials leave open.",
        (plots(figures, "A line for each number of poses; lower is better."),),
    )


def _confusion(cells: Sequence[CellSummary]) -> Section:
    blocks = [
        plot(confusion_map(said), caption)
        for large, caption in ((False, "Smaller than what is found in 90 of 100"), (True, "At least as large"))
        if (said := confusion(cells, large))
    ]
    return Section(
        "confusion", "What is said of what", "Rows are what is hidden, columns what was said.", tuple(blocks)
    )


def _coverage(cells: Sequence[CellSummary]) -> Section:
    rows = [(name, inside, of, f"{100.0 * inside / of:.0f} %") for name, (inside, of) in coverage(cells).items()]
    lead = "Of faults named outright at their place: how many intervals of 95 % hold the truth."
    header = ("parameter", "inside", "of", "share")
    body = table(header, [(n, str(i), str(o), s) for n, i, o, s in rows], "Intervals") if rows else prose("None yet.")
    return Section("coverage", "Do intervals hold?", lead, (body,))


def _range(one: Held) -> str:
    return "" if one.off is None else f" ({one.off.low:.2f} to {one.off.high:.2f})"


def _held(held: Sequence[Held]) -> Section:
    rows = [
        (
            title_of(h.summary),
            _told(h, h.predicted),
            _told(h, h.measured),
            "" if h.low is None and h.high is None else f"{_told(h, h.low)} to {_told(h, h.high)}",
            "–" if h.ratio is None else f"{h.ratio:.2f}{_range(h)}",
            "yes" if h.agrees else "within the trials' interval" if h.within_interval else "NO",
        )
        for h in sorted(held, key=lambda h: h.agrees)
    ]
    header = ("fault", "power says", "trials say", "their interval", "power over trials", f"within {FACTOR:g}")
    lead = f"{sum(h.agrees for h in held)} of {len(held)} predictions are within a factor of {FACTOR:g}."
    return Section("power", "Power against trials", lead, (table(header, rows, "Sizes found in 90 of 100"),))


def _told(h: Held, value: float | None) -> str:
    if h.summary.curve is None:
        return "–" if value is None else f"{100 * value:.0f} %"
    return amount(value, h.summary.unit)


def _interval(found: Found, unit: str) -> str:
    if found.size is None:
        return "no size"
    high = "no size" if found.high is None else amount(found.high, unit)
    return f"{amount(found.size, unit)} ({amount(found.low, unit)} to {high})"
