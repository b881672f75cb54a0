"""The validation line before and after (Figures 5 and 6)."""

from __future__ import annotations

from armtwin.scenarios.report.data import RunData
from armtwin.scenarios.report.line_figures import LABELS, line_displacements, line_error, line_path
from armtwin.scenarios.report.section import Section, number, plot, plots, table


def validation_section(run: RunData) -> Section:
    """Show path, displacements and error of the validation trajectory before and after."""
    found = run.results["figures"]["5_and_6"]
    runs, goal = found["runs"], found["commanded_mm"]
    paper = run.results["validation"]["paper"]
    paper_mean_mm = {name: paper[f"mean_{name}_mm"] for name in runs}
    rows = [
        [
            label,
            number(paper_mean_mm[name], 4),
            number(runs[name]["mean_mm"], 4),
            number(runs[name]["true_mean_mm"], 4),
            number(runs[name]["max_mm"], 3),
            number(runs[name]["vision_error_mm"], 4),
        ]
        for name, label in ((name, LABELS[name]) for name in runs)
    ]
    rows.append(["reduction, %", number(paper["reduction_percent"], 1), number(found["reduction_percent"], 1)])
    return Section(
        slug="validation",
        title="The line, before and after (Figures 5 and 6)",
        lead=(
            f"Commanded again through the calibrated inverse kinematics, the tip's mean error on a line that no "
            f"calibration has seen falls from {number(found['mean_before_mm'], 2)} to "
            f"{number(found['mean_after_mm'], 2)} mm, by {number(found['reduction_percent'], 1)} %."
        ),
        blocks=(
            plot(
                line_path(goal, runs),
                "The tip's path as the camera measured it. Lines join each pose to where it should be.",
            ),
            plots(line_displacements(goal, runs), "Figure 5: x and y along the line, commanded and measured."),
            plot(
                line_error(runs, paper_mean_mm),
                "Figure 6: distance of the tip from the commanded path (equation 19). Dashed: the "
                "paper's means. Thin: what the error truly was, which only a simulated bench can tell.",
            ),
            table(
                ["", "paper, mean mm", "here, mean mm", "true mean, mm", "largest, mm", "camera's own error, rms mm"],
                [row + ["–"] * (6 - len(row)) for row in rows],
                "The camera's own error is the distance of the measured from the true tip.",
                marked=[2],
            ),
        ),
    )
