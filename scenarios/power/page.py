"""The page of a plan's power: what it can see and what not, for people who plan."""

from __future__ import annotations

from armtwin.scenarios.power.figures import found_curves, said_of, sizes_found
from armtwin.scenarios.power.power import Power
from armtwin.scenarios.power.words import about, known_to, label, needed, taken_for, unit_words
from armtwin.scenarios.report.page import page
from armtwin.scenarios.report.section import Section, fold, plot, plots, prose, table
from armtwin.scenarios.sweeps.figures import confusion_map


def power_page(name: str, result: Power, *more: Section) -> str:
    """Return the report's HTML; `more` are sections that follow."""
    sized = [one for one in result.places if not one.fixed and not one.why_not]
    never = [one for one in sized if one.size_90 is None]
    answers = [
        (f"{len(sized) - len(never)} of {len(sized)}", "faults and places that some size is found of in 90 of 100"),
        (f"{len(result.inseparable)}", "pairs that these poses cannot tell apart at any size"),
        (f"{len(result.setting.plan)}", "poses"),
        (f"{result.setting.noise_px:g} px", "noise of a coordinate"),
    ]
    sections = [_seen(result), _pairs(result), _table(result), _seems(result), _curves(result), *more]
    return page(f"What {name} can see", about(result.setting), answers, sections, key=("extended", "geometry"))


def _seen(result: Power) -> Section:
    units = list(dict.fromkeys(one.unit for one in result.places if one.size_50 is not None))
    units.sort(key=lambda unit: -sum(one.unit == unit for one in result.places))
    blocks = [
        plot(sizes_found(result.places, unit), f"Faults measured in {unit_words(unit) or 'shares'}") for unit in units
    ]
    lead = (
        "Left of its dots a fault goes unseen; right of them it is named, at its place, in so many of 100 recordings."
    )
    blind = [
        label(one.effect, one.site)
        for one in result.places
        if not one.why_not and not one.fixed and one.size_90 is None
    ]
    if blind:
        blocks.append(prose(f"Found in 90 of 100 recordings at no size that is hidden: {'; '.join(blind)}."))
    return Section("seen", "Which faults can be seen?", lead, tuple(blocks))


def _pairs(result: Power) -> Section:
    rows = [(label(one.effect, one.site), rival) for one, rival in result.inseparable]
    if not rows:
        return Section("pairs", "What cannot be told apart", "Nothing: every rival leaves too much unexplained.")
    lead = "One explains all but a hundredth of what the other does, whatever the size: other poses are needed."
    return Section("pairs", "What cannot be told apart", lead, (table(("hidden", "seems"), rows, "Inseparable pairs"),))


def _table(result: Power) -> Section:
    rows = [
        (label(one.effect, one.site), "–", "–", "–", "", one.why_not)
        if one.why_not
        else (
            label(one.effect, one.site),
            needed(one, 50),
            needed(one, 90),
            "–" if one.moves is None else f"{one.moves:.2f}",
            known_to(one),
            taken_for(one),
        )
        for one in result.places
    ]
    header = (
        "fault",
        "found in 50 of 100 from",
        "in 90 of 100 from",
        "moves, noises",
        "then known to",
        "at half that it seems",
    )
    lead = "Sizes are the fault's own; 'moves' is what the geometry cannot take up, RMS over all coordinates."
    return Section("table", "In numbers", lead, (table(header, rows, "Every fault and place", marked=(2,)),))


def _seems(result: Power) -> Section:
    lead = "Rows are what is there, at half the size that is found in 90 of 100; columns what the diagnosis would say."
    return Section(
        "seems", "What does a smaller fault seem?", lead, (plot(confusion_map(said_of(result.places)), lead),)
    )


def _curves(result: Power) -> Section:
    effects = list(dict.fromkeys(one.effect for one in result.places if one.sizes and not one.fixed))
    figures = [found_curves([one for one in result.of(name) if one.sizes]) for name in effects]
    caption = "Lines: averaged over the forms that a fault may take; bands: from the hardest to the easiest form."
    return Section("curves", "Found, against size", caption, (fold("All curves", (plots(figures, caption),)),))
