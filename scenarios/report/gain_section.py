"""The validation trajectory once more, commanded by the extended twin."""

from __future__ import annotations

from typing import Any

from armtwin.scenarios.report.data import RunData
from armtwin.scenarios.report.line_figures import LABELS, line_displacements, line_error, line_path
from armtwin.scenarios.report.section import Cell, Section, number, plot, plots, prose, table


def gain_section(run: RunData) -> Section:
    """Show the three runs of the validation trajectory, and close with paper, geometry and extended twin."""
    line, gain = run.results["figures"]["5_and_6"], run.results["gain"]
    runs = {**line["runs"], "extended": gain["run"]}
    goal = line["commanded_mm"]
    rows = {row["run"]: row for row in gain["rows"]}
    paper = {name: row["paper_mean_mm"] for name, row in rows.items() if row["paper_mean_mm"] is not None}
    floor = gain["noise_floor_mm"]
    first, last = rows["before"], rows["extended"]
    return Section(
        slug="gain",
        title="The line, by the extended twin",
        lead=(
            f"Commanded a third time, through the inverse kinematics of the extended twin, the line is missed by "
            f"{number(last['mean_mm'], 3)} mm on average: {number(last['reduction_percent'], 1)} % less than the "
            f"{number(first['mean_mm'], 2)} mm before calibration. The camera itself is off by "
            f"{number(last['vision_error_mm'], 3)} mm RMS; its noise alone would show a mean of {floor:.3f} mm."
        ),
        blocks=(
            prose(_how(gain)),
            plot(line_path(goal, runs), "The tip's path as the camera measured it, three times."),
            plots(line_displacements(goal, runs), "As Figure 5: x and y along the line, commanded and measured."),
            plot(
                line_error(runs, paper, floor),
                "As Figure 6, on a logarithmic scale: distance of the tip from the commanded path. Dotted: the mean "
                "that noise alone would show. Thin: the true error, which only a simulated bench can tell.",
            ),
            table(
                ["mean error on the line, mm", "paper", *(LABELS[name] for name in rows)],
                _closing(rows, run.results["validation"]["paper"], gain["corrected_camera"]),
                "The paper's figures are those before and after its calibration. Intervals are 95 %, bootstrapped over "
                "stretches of five poses; percentages are against the same arm before calibration. The camera's own "
                "error is the distance of the measured from the true tip, which only a simulated bench can tell.",
                marked=[4],
            ),
        ),
    )


def _how(gain: dict[str, Any]) -> str:
    if not gain["corrected_with"]:
        return (
            "The diagnosis names no cause, so its twin is the calibrated geometry and nothing else: this run repeats "
            "the one before it, up to noise and to which poses the geometry was fitted to."
        )
    causes = ", ".join(gain["corrected_with"])
    text = (
        f"Corrected for: {causes}. Play and friction depend on where the arm comes from. So the bench first did again, "
        "unseen, all that it had done in the recording that was diagnosed, and the commands go on from there."
    )
    if gain["verdict"] == "ambiguous":
        text += " Causes that these poses cannot tell apart predict alike here, so the one that was fitted serves."
    if gain["corrected_camera"]:
        text += (
            " The pictures are measured through the camera as it was calibrated, as in the runs before: what is wrong "
            "with the camera itself shows here as an error of the arm. The closing table measures all three once more "
            "through the camera as the extended twin has it."
        )
    if gain["verdict"] == "unknown":
        text += " No cause is proven: the model that comes nearest was used, and may be wrong on other poses."
    return text


def _closing(rows: dict[str, dict[str, Any]], paper: dict[str, float], corrected_camera: bool) -> list[list[Cell]]:
    def line(label: str, printed: Cell, key: str, digits: int) -> list[Cell]:
        return [label, printed, *(number(row[key], digits) for row in rows.values())]

    def between(label: str, key: str, digits: int) -> list[Cell]:
        return [label, "–", *(" to ".join(number(end, digits) for end in row[key]) for row in rows.values())]

    before, after = (number(paper[f"mean_{name}_mm"], 2) for name in ("before", "after"))
    return [
        line("mean, as measured", f"{before} → {after}", "mean_mm", 3),
        between("its 95 % interval", "mean_ci95_mm", 3),
        line("less than before calibration, %", number(paper["reduction_percent"], 1), "reduction_percent", 1),
        between("its 95 % interval", "reduction_ci95_percent", 1),
        line("standard deviation along the line", "–", "std_mm", 3),
        line("largest", "–", "max_mm", 3),
        *([line("mean, through the twin's camera", "–", "mean_by_twin_camera_mm", 3)] if corrected_camera else []),
        line("mean, as it truly was", "–", "true_mean_mm", 3),
        line("camera's own error, RMS", "–", "vision_error_mm", 3),
    ]
