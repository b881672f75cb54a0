"""One world of a sweep: drawn from its own seed, recorded, diagnosed and judged."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from armtwin.calib.diagnosis.diagnosis import diagnose
from armtwin.models.arm import nominal_arm
from armtwin.models.errors import ArmtwinError
from armtwin.models.plan import Plan
from armtwin.models.recordings.recording import Recording
from armtwin.scenarios.plans import load_plan
from armtwin.scenarios.scoring.judge import Judgement, judge, label, name_said
from armtwin.scenarios.scoring.outcome import outcome_of
from armtwin.scenarios.sweeps.table import DRAWN, Cell, place_of
from armtwin.sim.sealed import Sealed, Wanted, draw_of_size

Row = dict[str, Any]


@dataclass(frozen=True)
class Trial:
    """World `number` of a cell, with what is hidden in it of `size`, and the plan that its cell names.

    The seed of a world is that of the sweep, its cell's number and its own: it is the same wherever it is made.
    """

    cell: Cell
    number: int
    size: float
    seed: int
    plan: Plan | None = None

    @property
    def key(self) -> tuple[int, int]:
        """(cell, number): what tells this world from all others of the sweep."""
        return self.cell.number, self.number

    def rng(self) -> np.random.Generator:
        """Return the generator of this world."""
        return np.random.default_rng(np.random.SeedSequence(self.seed, spawn_key=(1, *self.key)))


def plan_of_cell(cell: Cell) -> Plan | None:
    """Return the poses of a cell's plan, thinned to its number of poses; None where every world draws its own."""
    if cell.plan == DRAWN:
        return None
    plan = load_plan(cell.plan, nominal_arm())
    if cell.poses >= len(plan):
        return plan
    rows = np.linspace(0, len(plan) - 1, cell.poses).round().astype(int)
    return Plan(plan.trajectory[rows], plan.q_cmd[rows], plan.payload_kg[rows])


def draw(trial: Trial) -> Sealed:
    """Draw the world of a trial and record it."""
    cell, rng = trial.cell, trial.rng()
    place = place_of(cell.place)
    sealed = draw_of_size(
        rng,
        [Wanted(name, trial.size, place, relative=cell.is_pair) for name in cell.effects],
        plan=None if trial.plan is None else (trial.plan, ()),
        n_poses=cell.poses,
        noise_px=cell.noise_px,
        markers=tuple(cell.markers),
        declare_noise=cell.noise_declared,
    )
    if not cell.rendered:
        return sealed
    with TemporaryDirectory() as folder:
        return Sealed(_measured(Path(folder), sealed, rng), sealed.truth, sealed.world)


def run_trial(trial: Trial) -> Row:
    """Draw and diagnose the world of a trial and return its row; a world that cannot be drawn or decided says why."""
    start = time.process_time()
    try:
        sealed = draw(trial)
        drawn = time.process_time()
        outcome = outcome_of(diagnose(sealed.recording))
    except ArmtwinError as error:
        return _row(trial) | {"error": str(error), "cost": {"draw_s": time.process_time() - start}}
    truth = {"kind": "single" if trial.cell.effects else "null", **sealed.truth}
    judged = judge(truth, outcome | {"seconds": 0.0})
    cost = {"draw_s": drawn - start, "diagnose_s": time.process_time() - drawn}
    return _row(trial) | _answer(sealed, outcome, judged) | {"cost": cost}


def _row(trial: Trial) -> Row:
    cell = trial.cell
    return {
        "cell": cell.number,
        "trial": trial.number,
        "effect": cell.effect,
        "place": cell.place,
        "size": trial.size,
        "noise_px": cell.noise_px,
        "poses": cell.poses,
        "plan": cell.plan,
        "markers": cell.markers,
        "noise_declared": cell.noise_declared,
        "rendered": cell.rendered,
    }


def _answer(sealed: Sealed, outcome: Row, judged: Judgement) -> Row:
    held = outcome["held_out"]
    return {
        "hidden": judged.truth,
        "hidden_parameters": [
            {"name": f"{effect['effect']}.{name}", "value": float(value)}
            for effect in sealed.truth["effects"]
            for name, value in effect["parameters"].items()
            if isinstance(value, int | float)
        ],
        "verdict": outcome["verdict"],
        "said": name_said(outcome["verdict"], outcome["causes"]),
        "said_where": " + ".join(label(cause) for cause in outcome["causes"]),
        # At the right place, too, and nothing beside it that is not there.
        "found": judged.right and judged.site_right == judged.sited,
        "wrong": judged.wrong,
        "tied": judged.tied,
        "misses": [{"name": name, "value": float(miss)} for name, miss in judged.misses.items()],
        "intervals": [
            {"name": f"{cause['effect']}.{name}", "value": float(interval["value"]), "std": float(interval["std"])}
            for cause in outcome["causes"]
            for name, interval in cause["parameters"].items()
            if interval["std"] is not None
        ],
        "before_mm": held["before_rms_mm"],
        "after_mm": held["after_rms_mm"],
        "n_poses": int(sealed.truth["n_poses"]),
    }


def _measured(folder: Path, sealed: Sealed, rng: np.random.Generator) -> Recording:
    from armtwin.scenarios.scoring.sealing import filmed  # brings the renderer along, which few sweeps need

    return filmed(folder, sealed.recording, sealed.world, rng)
