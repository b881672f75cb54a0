"""Gather what the stages found into `results.json`: every table and figure of the paper as data, beside its numbers."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.arm.chain import Chain
from armtwin.models import atomic
from armtwin.models.kinematics import is_closed_form
from armtwin.models.recordings.reader import camera_from_table
from armtwin.models.validation import CameraTable, check
from armtwin.scenarios import paper_values as paper
from armtwin.scenarios.runner.job import Job
from armtwin.scenarios.runner.named import diagnosis_results
from armtwin.scenarios.runner.stage import Tick
from armtwin.scenarios.runner.truth import truth_table
from armtwin.scenarios.runner.world import declared_arm, true_camera, true_deviation

Array = NDArray[np.float64]

SCHEMA = "armtwin.run/1"


def gather(job: Job, tick: Tick) -> dict[str, Any]:
    """Write `truth.json` and `results.json`."""
    atomic.write_json(job.out / "truth.json", truth_table(job.scenario))
    results = {
        "schema": SCHEMA,
        "scenario": {"title": job.scenario.title, "about": job.scenario.about.strip(), "seed": job.scenario.seed},
        "tables": {
            "1": _table_1(job),
            "2": _table_2(job),
            "3": job.load("gauges")["rows"],
            "4": _table_4(job),
        },
        "figures": {
            "3": {"recording": "recordings/before", "sample": 0},
            "4": _figure_4(job),
            "5_and_6": job.load("validation"),
        },
        "camera": {key: job.load("camera")[key] for key in ("rms_px", "per_view_rms_px", "views")},
        "markers": {name: _unseen(job, name) for name in ("before", "after", "extended")},
        "validation": _validation(job),
        "diagnosis": diagnosis_results(job),
        "gain": job.load("gain"),
    }
    atomic.write_json(job.out / "results.json", results)
    tick(1, 1)
    return {"written": ["truth.json", "results.json"]}


def _table_1(job: Job) -> list[dict[str, Any]]:
    arm = declared_arm(job.scenario)
    built = arm.link_lengths_mm + true_deviation(job.scenario).lengths_mm
    names = [f"l{number}" for number in arm.length_numbers]
    printed = paper.TABLE_1_MM if is_closed_form(arm) else {}
    return [
        {"parameter": name, "unit": "mm", "paper": printed.get(name), "drawn": drawn, "built": true}
        for name, drawn, true in zip(names, arm.link_lengths_mm, built, strict=True)
    ]


def _table_2(job: Job) -> list[dict[str, Any]]:
    found, true = job.load("camera"), true_camera(job.scenario)
    camera = camera_from_table(check(CameraTable, found["camera"], "stages/camera.json"))
    truth = {"fx": true.K[0, 0], "fy": true.K[1, 1], "cx": true.K[0, 2], "cy": true.K[1, 2], **true.lens.named}
    rows = [
        {
            "parameter": name,
            "unit": "px" if name in ("fx", "fy", "cx", "cy") else "1",
            "paper": paper.TABLE_2[name],
            "estimate": found["intrinsics"][name],
            "std": found["std"][name],
            "jackknife_std": found["jackknife_std"][name],
            "truth": value,
        }
        for name, value in truth.items()
    ]
    turn = true.R_board_camera.T @ camera.R_board_camera
    angle = np.arccos(np.clip((np.trace(turn) - 1) / 2, -1, 1))
    for axis, name in enumerate(("tx", "ty", "tz")):
        rows.append(
            {
                "parameter": name,
                "unit": "mm",
                "paper": paper.TABLE_2[name],
                "estimate": camera.t_board_camera_mm[axis],
                "std": found["pose_std"][3 + axis],
                "truth": true.t_board_camera_mm[axis],
            }
        )
    rows.append(
        {
            "parameter": "rotation",
            "unit": "rad",
            "paper": None,
            "estimate": angle,
            "std": float(np.linalg.norm(found["pose_std"][:3])),
            "truth": 0.0,
        }
    )
    return rows


def _table_4(job: Job) -> dict[str, Any]:
    found = job.load("calibration")
    chain = Chain(declared_arm(job.scenario))
    is_papers = is_closed_form(chain.arm)  # otherwise what it printed is of another arm
    delta = true_deviation(job.scenario)
    gauged = chain.in_convention(delta)
    table: dict[str, Any] = {"sets": found["sets"], "rows": [], "corrected_with": found["corrected_with"]}
    truth = np.concatenate([delta.lengths_mm, delta.joints_rad])
    in_convention = np.concatenate([gauged.lengths_mm, gauged.joints_rad])
    for number, name in enumerate(chain.names):
        row: dict[str, Any] = {
            "parameter": name,
            "unit": name.rsplit("_", 1)[1],
            "paper": paper.TABLE_4[name] if is_papers else None,
            "paper_uncertainty": paper.TABLE_4_UNCERTAINTY[name] if is_papers else None,
            "truth": truth[number],
            "truth_in_convention": in_convention[number],
        }
        for method, tables in found["methods"].items():
            row[method] = [
                {key: t["parameters"][name][key] for key in ("value", "std", "clustered_std", "interval95")}
                for t in tables
            ]
        table["rows"].append(row)
    for method, tables in found["methods"].items():
        table[method] = [
            {key: t[key] for key in ("trajectories", "identifiable", "gauge", "ties", "rms_mm", "rms_px", "n_used")}
            for t in tables
        ]
    table["singular_values"] = found["methods"]["least-squares"][-1]["singular_values"]
    return table


def _figure_4(job: Job) -> dict[str, Any]:
    taken = job.load("capture_before")
    names = np.array(taken["trajectory"])
    return {
        name: {
            "poses_mm_rad": path.poses(),
            "q_cmd_rad": np.array(taken["q_cmd_rad"])[names == name],
        }
        for name, path in job.scenario.trajectories.items()
    }


def _unseen(job: Job, recording: str) -> dict[str, Any]:
    found = job.load(f"measure_{recording}")
    return {method: {"unseen": table["unseen"], "messages": table["messages"]} for method, table in found.items()}


def _validation(job: Job) -> dict[str, Any]:
    found = job.load("validation")
    keys = ("trajectory", "mean_before_mm", "mean_after_mm", "reduction_percent")
    return {key: found[key] for key in keys} | {"paper": paper.VALIDATION}
