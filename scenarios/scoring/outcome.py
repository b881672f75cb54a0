"""What the diagnosis says of one sealed recording, as plain data that can be kept and judged."""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import armtwin.calib.diagnosis
import armtwin.models.catalogue
import armtwin.models.effects
from armtwin.calib.diagnosis.diagnosis import Diagnosis, NamedCause, diagnose
from armtwin.models import atomic
from armtwin.models.catalogue.context import Context
from armtwin.models.catalogue.predict import Active
from armtwin.models.catalogue.registry import registered_files
from armtwin.models.recordings.reader import read_recording
from armtwin.scenarios.diagnosis.causes import cause_table, place_of
from armtwin.scenarios.scoring.sealing import world_folder

Array = NDArray[np.float64]

_CONSIDERED = 5


@dataclass(frozen=True)
class Task:
    """World `index` of the set in `out`, to be diagnosed by code of this `version`."""

    out: Path
    index: int
    version: str


def code_version() -> str:
    """Return a digest of the diagnosis and of all effects: results of other code are not to be counted."""
    digest = hashlib.sha256()
    for package in (armtwin.calib.diagnosis, armtwin.models.catalogue, armtwin.models.effects):
        for path in sorted(Path(package.__path__[0]).glob("*.py")):
            digest.update(path.read_bytes())
    for path in registered_files():
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def outcome_path(out: Path, index: int) -> Path:
    """Return where a world's outcome is kept."""
    return out / "score" / f"{index:04d}.json"


def kept_outcome(task: Task) -> dict[str, Any] | None:
    """Return the outcome of an earlier run of the same code on the same recording, or None; also for a changed file."""
    path = outcome_path(task.out, task.index)
    if not path.is_file():
        return None
    try:
        kept: Any = json.loads(path.read_text("utf-8"))
    except (ValueError, RecursionError):  # cut off, or somebody else's: made again
        return None
    digest = kept.pop("digest", None) if isinstance(kept, dict) else None
    if digest is None or digest != _outcome_digest(kept):
        return None
    same = kept.get("version") == task.version and kept.get("recording") == _recording_digest(task)
    return kept if same else None


def diagnose_world(task: Task) -> dict[str, Any]:
    """Diagnose a world, keep the outcome on disk and return it."""
    recording = read_recording(world_folder(task.out, task.index))
    started = time.process_time()  # of this one core, however busy the machine is
    diagnosis = diagnose(recording)
    seconds = time.process_time() - started
    outcome = {
        "version": task.version,
        "recording": _recording_digest(task),
        "seconds": seconds,
        "n_poses": len(recording),
        **outcome_of(diagnosis),
    }
    path = outcome_path(task.out, task.index)
    atomic.write_json(path, outcome)
    read_back: dict[str, Any] = json.loads(path.read_text("utf-8"))
    atomic.write_json(path, {**read_back, "digest": _outcome_digest(read_back)})
    return read_back


def outcome_of(diagnosis: Diagnosis) -> dict[str, Any]:
    """Return verdict, causes with intervals, geometry, held-out errors and the candidates that came nearest."""
    found, context = diagnosis.explanation, diagnosis.problem.context
    geometry, held_out = diagnosis.geometry, diagnosis.held_out
    considered = found.considered[:_CONSIDERED]
    return {
        "verdict": diagnosis.verdict,
        "causes": [_cause(cause, context) for cause in diagnosis.causes],
        "suspects": [_cause(cause, context) for cause in diagnosis.suspects],
        "considered": [{**_site(c.active, context), "score": c.score, "label": c.active.label} for c in considered],
        "structure": [trend.against for trend in diagnosis.trends_after],
        "excess": found.excess,
        "remaining": found.remaining,
        "deviance": {"geometric": found.geometric.deviance, "final": found.final.deviance},
        "noise": found.data.noise,
        "gauge": list(geometry.gauge),
        "geometry": {
            name: {"value": float(value), "std": float(std)}
            for name, value, std in zip(geometry.names, geometry.values, geometry.std, strict=True)
        },
        "held_out": {
            "before_rms_mm": held_out.before_rms_mm,
            "after_rms_mm": held_out.after_rms_mm,
            "after_median_mm": held_out.after_median_mm,
            "noise_floor_mm": held_out.noise_floor_mm,
            "gain_percent": held_out.gain_percent,
        },
    }


def _cause(cause: NamedCause, context: Context) -> dict[str, Any]:
    return cause_table(cause, _intervals(cause, context), lambda active: _site(active, context))


def _site(active: Active, context: Context) -> dict[str, Any]:
    site = place_of(active)
    partner = active.effect.partner
    return (
        site if partner is None else site | {partner: active.effect.built(context, active.site, active.values)[partner]}
    )


def _intervals(cause: NamedCause, context: Context) -> dict[str, Any]:
    """Value and standard deviation by the names that the simulated bench gives them; switches have no interval."""
    effect = cause.active.effect
    parameters = effect.parameters(context, cause.active.site)
    if effect.found is not None:  # found sample by sample, so there is no parameter
        return {}
    if effect.physical is not None:
        values = effect.physical(context, cause.active.values)
        spread = _propagated(partial(effect.physical, context), cause.active.values, cause.std)
        return {name: {"value": value, "std": spread[name]} for name, value in values.items()}
    told = range(len(parameters)) if effect.told is None else effect.told(context, cause.active.values)
    return {
        parameters[k].name: {
            "value": float(cause.active.values[k]),
            "std": float(cause.std[k]),
            "switch": parameters[k].scanned and parameters[k].bounds == (0.0, 1.0),
            "off": parameters[k].off,
        }
        for k in told
    }


def _propagated(physical: Callable[[Array], Mapping[str, float]], values: Array, std: Array) -> dict[str, float]:
    """Standard deviations of functions of independent values, to first order; of those that are told at the values."""
    at = physical(values)
    variance = dict.fromkeys(at, 0.0)
    for k, sigma in enumerate(std):
        moved = values.copy()
        moved[k] += 1e-3 * sigma
        for name, value in physical(moved).items():
            if name not in at:  # told only where it is not zero
                continue
            variance[name] += ((value - at[name]) / 1e-3) ** 2
    return {name: float(np.sqrt(v)) for name, v in variance.items()}


def _outcome_digest(outcome: Mapping[str, Any]) -> str:
    return hashlib.sha256(json.dumps(outcome, sort_keys=True).encode()).hexdigest()[:16]


def _recording_digest(task: Task) -> str:
    return hashlib.sha256((world_folder(task.out, task.index) / "samples.csv").read_bytes()).hexdigest()[:16]
