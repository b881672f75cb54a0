"""What is left after the geometric calibration, and what the diagnosis names, beside what was injected."""

from __future__ import annotations

from typing import Any

from markupsafe import Markup

from armtwin.models.catalogue.registry import effect_named
from armtwin.scenarios.report.data import RunData
from armtwin.scenarios.report.section import Cell, Section, fold, number, prose, table

# Chapters of the diagnosis' own report that show what is left and what it follows.
_SHOWN = ("where", "structure")
_FOLDED = ("considered", "geometry", "next", "notes")
# Samples that a cell of a table may list.
_MOST_LISTED = 8


def remainder_section(run: RunData) -> Section:
    """Show where the calibrated arm is still wrong, and what the error follows."""
    chapters = _chapters(run)
    held = run.results["diagnosis"]["held_out"]
    return Section(
        slug="remainder",
        title="What geometry leaves",
        lead=(
            f"The calibrated arm misses the markers of the held-out line by {held['before_rms_mm']:.3f} mm RMS; the "
            f"noise of the pictures alone would be {held['noise_floor_mm']:.3f} mm. What remains is looked at from all "
            "sides, by a diagnosis that knows the recording and nothing else."
        ),
        blocks=tuple(block for slug in _SHOWN if slug in chapters for block in _shown(chapters[slug])),
    )


def causes_section(run: RunData) -> Section:
    """State what the diagnosis names, each parameter with its interval beside the truth."""
    found = run.results["diagnosis"]
    chapters = _chapters(run)
    words = found["words"]
    rows = [row for cause in found["beside_truth"] for row in _rows(cause)]
    blocks: list[Markup] = []
    if rows:
        blocks.append(table(_HEADER, rows, _caption(found), marked=(2, 3)))
    remarks = [remark for cause in found["beside_truth"] if (remark := _remark(cause)) is not None]
    blocks += [prose(line) for line in (*remarks, *words["ties"])]
    blocks.append(prose(f"{words['gain']} {words['resimulated']}"))
    inner = [block for slug in _FOLDED if slug in chapters for block in _shown(chapters[slug])]
    blocks.append(fold("What else was considered, the geometry that was fitted along, and what to do next", inner))
    blocks.append(
        prose(
            "The whole diagnosis is diagnosis/report.html. The extended twin is diagnosis/twin.toml: the arm with "
            "these causes in it, from which the simulated bench is rebuilt."
        )
    )
    return Section("causes", "What the diagnosis names", _lead(found), tuple(blocks))


_HEADER = ["cause", "parameter", "found ± σ", "95 % interval", "truth", "off by"]


def _remark(cause: dict[str, Any]) -> str | None:
    """Say of a cause that was not named right what it is."""
    name = f"{cause['effect']}, {_place(cause)}"
    if cause["label"] is None:
        return f"{name}, was injected and is not named."
    if cause["origin"] == "calibration":
        return f"{name}, was not injected: the camera's calibration left it, and the truth is how far that is off."
    return f"{name}, was not injected." if cause["origin"] is None else None


def _lead(found: dict[str, Any]) -> str:
    injected = any(row["origin"] == "injected" for row in found["beside_truth"])
    text = str(found["words"]["headline"])
    if injected:
        text += (
            " The truth beside it was built into the bench's physics by us (the scenario file says why), and is shown "
            "only because this is a simulation."
        )
    return text


def _caption(found: dict[str, Any]) -> str:
    text = (
        "A truth that the scenario leaves out is zero; switches have none (–). σ is what noise makes of an estimate: a "
        "term of the model is not quite what a body in MuJoCo does, so an error of a percent may well be many σ."
    )
    if found["verdict"] == "unknown":
        text = f"The cause is unknown: what is listed comes nearest and is not proven. {text}"
    return text


def _rows(cause: dict[str, Any]) -> list[list[Cell]]:
    name = f"{cause['effect']}, {_place(cause)}"
    rows = [["" if k else name, *_parameter(one)] for k, one in enumerate(cause["parameters"] or [None])]
    return [*rows, *([f"or {other['effect']}, {_place(other)}", *_parameter(None)] for other in cause["equivalents"])]


def _parameter(parameter: dict[str, Any] | None) -> list[Cell]:
    """Return name, estimate, interval, truth and how far the estimate is from it."""
    if parameter is None:
        return ["", "", "", "", ""]
    value, std, interval, truth = (parameter[key] for key in ("value", "std", "interval95", "truth"))
    text, between, off = "–", "–", "–"
    if value is not None:
        known = std is not None and std > 1e-9 * max(abs(value), 1.0)
        text = f"{_short(value)} ± {std:.2g}" if known else _short(value)
        if known and None not in interval:
            between = f"{_short(interval[0])} to {_short(interval[1])}"
        if truth:
            off = f"{number(100.0 * (value / truth - 1.0), 1)} %"
    return [parameter["name"], text, between, "–" if truth is None else stated(truth), off]


def stated(truth: float | str | list[int]) -> str:
    """Return a truth as the scenario states it: a number, a marker's name, or samples."""
    if isinstance(truth, list):
        return ", ".join(map(str, truth[:_MOST_LISTED])) + (" …" if len(truth) > _MOST_LISTED else "")
    return truth.upper() if isinstance(truth, str) else _short(truth)


def _short(value: float) -> str:
    return f"{value:.4g}".replace("-", "−")


def _place(cause: dict[str, Any]) -> str:
    if cause["joint"] is not None:
        return f"joint {cause['joint']}"
    if cause["marker"] is not None:
        return f"marker {cause['marker'].upper()}"
    return "camera" if effect_named(cause["effect"]).where == "camera" else "whole arm"


def _chapters(run: RunData) -> dict[str, dict[str, Any]]:
    return {chapter["slug"]: chapter for chapter in run.stage("diagnose")["chapters"]}


def _shown(chapter: dict[str, Any]) -> list[Markup]:
    """Return a chapter of the diagnosis' report without its heading; its blocks were escaped when they were made."""
    blocks = [Markup(block) for block in chapter["blocks"]]  # noqa: S704
    return [prose(chapter["lead"]), *blocks] if chapter["lead"] else blocks
