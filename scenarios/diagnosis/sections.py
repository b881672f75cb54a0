"""The chapters of a diagnosis, in the order in which its story is told."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from markupsafe import Markup

from armtwin.calib.diagnosis.diagnosis import Diagnosis, NamedCause
from armtwin.calib.diagnosis.experiment import Experiment
from armtwin.calib.diagnosis.structure import Trend
from armtwin.calib.setup.screen import Screened
from armtwin.scenarios.diagnosis import figures
from armtwin.scenarios.diagnosis.looks import remainder_in_words
from armtwin.scenarios.diagnosis.ranking import Ranked, rank_causes
from armtwin.scenarios.diagnosis.remainder import Remainder, remainder, sightings
from armtwin.scenarios.diagnosis.resimulate import Resimulation
from armtwin.scenarios.diagnosis.structure import ResidualPlot, residual_plots
from armtwin.scenarios.diagnosis.words import gain, missed, parameter_rows, site_words, what_next, why_tied
from armtwin.scenarios.report.section import Cell, Section, fold, number, plot, plots, prose, table, with_std


@dataclass(frozen=True, eq=False)
class DiagnosisReport:
    """A diagnosis with all that its report shows."""

    diagnosis: Diagnosis
    resimulation: Resimulation
    experiment: Experiment | None
    notes: Sequence[str]
    screened: Screened


def diagnosis_sections(report: DiagnosisReport) -> list[Section]:
    """Return the chapters."""
    diagnosis = report.diagnosis
    seen = sightings(diagnosis)
    before = remainder(diagnosis, diagnosis.explanation.geometric, seen)
    final = diagnosis.explanation.final
    after = remainder(diagnosis, final, seen) if final.effects else None
    shown = residual_plots(diagnosis, before, after)
    sections = [*_set_up(report), _causes(report)]
    if before.points_mm is not None:
        sections.append(_where(before, after))
    sections += [
        _structure(diagnosis, shown),
        _considered(diagnosis, rank_causes(diagnosis)),
        _gain(report, before, after),
        _geometry(diagnosis),
    ]
    if report.experiment is not None or diagnosis.verdict in ("ambiguous", "unknown"):
        sections.append(_next(report))
    if report.notes:
        sections.append(
            Section("notes", "What this recording cannot tell", "", tuple(prose(note) for note in report.notes))
        )
    return sections


def _set_up(report: DiagnosisReport) -> list[Section]:
    """Show what is set up wrongly, before anything else."""
    lines = report.screened.sentences
    if not lines:
        return []
    lead = "This comes first: all that follows is of the recording without it."
    return [Section("set-up", "What is set up wrongly", lead, tuple(prose(line) for line in lines))]


def _causes(report: DiagnosisReport) -> Section:
    diagnosis = report.diagnosis
    causes = diagnosis.causes or diagnosis.suspects
    if not causes:
        return Section("causes", "No cause to name", _nothing(report))
    title = "What is wrong" if diagnosis.causes else "What comes nearest, and is not proven"
    lead = " ".join(
        f"{cause.active.effect.name} ({site_words(cause)}): {cause.active.effect.summary}." for cause in causes
    )
    blocks = [
        table(
            ["effect", "at", "explains", "parameter", "value", "95 % interval", "p-value"],
            [row for cause in causes for row in _cause_rows(cause, diagnosis)],
            "Each cause with its parameters. 'Explains' is the share of the misfit above the noise that is lost again "
            "when this cause is left out; the p-value is corrected for every effect and place that was tried.",
            marked=(4, 5),
        )
    ]
    ties = [line for cause in causes for line in why_tied(cause)]
    blocks += [prose(line) for line in ties]
    return Section("causes", title, lead, tuple(blocks))


def _cause_rows(cause: NamedCause, diagnosis: Diagnosis) -> list[list[Cell]]:
    parameters = parameter_rows(cause, diagnosis) or [("", "", "")]
    rows: list[list[Cell]] = []
    for k, (name, value, interval) in enumerate(parameters):
        head: list[Cell] = ["", "", ""]
        if k == 0:
            head = [cause.active.effect.name, site_words(cause), f"{cause.explained_percent:.1f} %"]
        rows.append([*head, name, value, interval, _p_value(cause.p_value) if k == 0 else ""])
    rows += [[f"or {other.effect.name}", str(other.site), "as well", "", "", "", ""] for other in cause.equivalents]
    return rows


def _nothing(report: DiagnosisReport) -> str:
    diagnosis = report.diagnosis
    if diagnosis.verdict == "none":
        return (
            "The calibrated geometry explains every pose to the noise, and what remains follows nothing. A fault that "
            "moves the markers by less than the noise, or one that these poses do not provoke, would not show."
        )
    if diagnosis.only_held_out:
        return "The poses held out are missed by more than the noise, the others are not, and no effect explains both."
    seen = remainder_in_words(diagnosis, report.screened.recording.sample)
    return f"No effect of the catalogue explains enough of what remains to be named. {seen}"


def _where(before: Remainder, after: Remainder | None) -> Section:
    figure, factor = figures.arrows(before, after)
    sides = (
        "" if after is None else ", alike on both sides: left the calibrated geometry alone, right the extended twin"
    )
    return Section(
        "where",
        "Where the twin is wrong",
        "Each arrow leads from where the twin puts a marker to where it was seen.",
        (
            plots(
                figure,
                f"Arrows {factor:g} times enlarged{sides}. Noise points anywhere; a cause has a pattern.",
            ),
        ),
    )


def _structure(diagnosis: Diagnosis, shown: Sequence[ResidualPlot]) -> Section:
    best = shown[0]
    blocks = [
        plot(
            figures.residual_figure(best),
            "Dots are poses, the line their mean in groups. A line that stays at zero is noise; one that bends or "
            "jumps is something that the twin does not know.",
        )
    ]
    if len(shown) > 1:
        blocks.append(
            plots(
                figures.residual_figures(shown[1:]),
                "Against everything else that could matter; of all markers and joints the one that shows most. The "
                "percentages are the shares of the variance that follow it, before → after.",
            )
        )
    blocks.append(_trend_table(diagnosis))
    return Section("structure", "What the error follows", _pattern(diagnosis, best), tuple(blocks))


def _pattern(diagnosis: Diagnosis, best: ResidualPlot) -> str:
    if best.ordinate.against not in {trend.against for trend in diagnosis.trends_before}:
        return "No pattern is beyond chance: against whatever the error is plotted, it could be noise."
    after = "" if best.share_after is None else f", {100 * best.share_after:.0f} % once the cause is modelled"
    return (
        f"The clearest pattern is against {best.ordinate.against}: {100 * best.share_before:.0f} % of "
        f"'{best.component.title}' follows it{after}."
    )


def _trend_table(diagnosis: Diagnosis) -> Markup:
    after = {trend.against: trend for trend in diagnosis.trends_after}
    before = {trend.against: trend for trend in diagnosis.trends_before}
    rows: list[list[Cell]] = [
        [against, _trend(before.get(against)), _trend(after.get(against))]
        for against in dict.fromkeys([*before, *after])
    ]
    if not rows:
        return prose("No test finds the remainder to follow anything, at a level of one in a thousand over all tests.")
    return table(
        ["the remainder follows", "calibrated geometry", "extended twin"],
        rows,
        "Tests on the poses that were fitted: the share of the remainder's variance that follows each thing. A dash is "
        "no significant trend.",
    )


def _trend(trend: Trend | None) -> str:
    return "–" if trend is None else f"{100.0 * trend.share:.0f} %"


def _considered(diagnosis: Diagnosis, ranked: Sequence[Ranked]) -> Section:
    if not ranked:
        return Section(
            "considered",
            "What was considered",
            "There is nothing above the noise for a cause to explain, so none was kept.",
        )
    rows: list[list[Cell]] = [
        [one.label, f"{100 * one.explained_share:.1f} %", number(one.score, 1), one.standing] for one in ranked
    ]
    several = len(diagnosis.causes) > 1
    lead = "Every effect was fitted at every place, jointly with the geometry; these came nearest."
    if several:
        lead += " Of several causes each alone explains only a part."
    return Section(
        "considered",
        "What was considered",
        lead,
        (
            plot(
                figures.candidates(ranked),
                "Green is named; light blue explains these poses as well; grey was turned down: it explains less, or "
                "needs more parameters for it.",
            ),
            fold(
                "Scores",
                [
                    table(
                        ["effect", "explains", "score", ""],
                        rows,
                        "Score: deviance and the penalty of its parameters; smaller is better.",
                    )
                ],
            ),
        ),
    )


def _gain(report: DiagnosisReport, before: Remainder, after: Remainder | None) -> Section:
    diagnosis, again = report.diagnosis, report.resimulation
    held = diagnosis.held_out
    kept = (
        f"Held out: {', '.join(held.trajectories)} ({held.description})."
        if held.trajectories
        else f"Held out: {held.description}."
    )
    return Section(
        "gain",
        "What it gains, on poses that were not fitted",
        f"{gain(diagnosis)} {missed(again)}",
        (
            prose(kept),
            plot(
                figures.held_out_bars(diagnosis, again.held_out_rms_mm),
                "The last bar is no fit: the arm of twin.toml, with its effects made physically, moved through the "
                "same commands in MuJoCo.",
            ),
            plot(figures.held_out_poses(diagnosis, before, after), "Pose by pose; the dashed line is the noise."),
        ),
    )


def _geometry(diagnosis: Diagnosis) -> Section:
    geometry = diagnosis.geometry
    rows: list[list[Cell]] = []
    for name, value, std in zip(geometry.names, geometry.values, geometry.std, strict=True):
        is_angle = name.endswith("_rad")
        label, factor = (
            (name.removesuffix("_rad") + ", °", 180.0 / np.pi) if is_angle else (name.replace("_mm", ", mm"), 1.0)
        )
        rows.append([label, with_std(factor * value, factor * std, 4)])
    return Section(
        "geometry",
        "The geometry that was fitted along",
        f"{geometry.identifiable} combinations of link lengths and joint zeros can be known from these poses.",
        (
            table(["parameter", "value ± standard deviation"], rows, "Fitted jointly with the causes.", marked=(1,)),
            *(prose(f"Cannot be known: {line}.") for line in geometry.gauge),
        ),
    )


def _next(report: DiagnosisReport) -> Section:
    lead = what_next(report.diagnosis, report.experiment)
    if report.experiment is None:
        return Section("next", "What to do next", lead)
    caption = "The proposed poses, in next_experiment.csv: a plan that a bench can run."
    return Section("next", "What to do next", lead, (plot(figures.plan(report.experiment.plan.q_cmd), caption),))


def _p_value(p: float) -> str:
    return "< 1e-12" if p < 1e-12 else f"{p:.1g}"
