"""Writing recordings of moving arms, and their columns."""

from __future__ import annotations

import csv
import io
import shutil
from pathlib import Path
from typing import Any

import numpy as np

from armtwin.models import atomic
from armtwin.models.arm import Arm
from armtwin.models.recordings.moving import ModelArm, MovingRecording
from armtwin.models.recordings.recording import SCHEMA
from armtwin.models.recordings.writer import arm_table


def write_moving_recording(folder: Path, recording: MovingRecording) -> None:
    """Write `recording.json`, `samples.csv` and the arm's model; the folder appears when all of it is there."""
    with atomic.folder_aside(folder) as aside:
        atomic.write_json(aside / "recording.json", _header(recording))
        atomic.write_text(aside / "samples.csv", samples_text(recording))
        if isinstance(recording.arm, ModelArm):
            shutil.copyfile(recording.arm.model, aside / recording.arm.model.name)


def declared_arm(arm: Arm | ModelArm) -> dict[str, Any]:
    """Return an arm as files state it; a model's file lies beside them."""
    if isinstance(arm, Arm):
        return arm_table(arm)
    return {"name": arm.name, "model": arm.model.name, "joints": list(arm.joints)}


def samples_text(recording: MovingRecording) -> str:
    """Return `samples.csv`; what was not measured is an empty cell."""
    columns = recording.columns()
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(columns)
    for row in zip(*columns.values(), strict=True):
        writer.writerow(_cell(value) for value in row)
    return out.getvalue()


def _cell(value: Any) -> str:
    if isinstance(value, float):
        return "" if np.isnan(value) else repr(float(value))
    return str(value)


def _header(recording: MovingRecording) -> dict[str, Any]:
    header: dict[str, Any] = {"schema": SCHEMA, "arm": declared_arm(recording.arm), "motion": "moving"}
    if recording.clock == "synthetic":
        header["clock"] = "synthetic"
    if recording.servo:
        header["servo"] = {name: list(values) for name, values in recording.servo.items()}
    if recording.settings:
        header["trajectories"] = {name: _settings(one) for name, one in recording.settings.items()}
    if recording.held_out:
        header["held_out"] = list(recording.held_out)
    return header


def _settings(settings: Any) -> dict[str, Any]:
    registers = {name: list(values) for name, values in settings.items() if name != "payload_kg"}
    out: dict[str, Any] = {"servo": registers} if registers else {}
    return {**out, **({"payload_kg": settings["payload_kg"]} if "payload_kg" in settings else {})}
