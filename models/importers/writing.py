"""An imported log written as a recording folder."""

from __future__ import annotations

import csv
import io
import shutil
from pathlib import Path
from typing import Any

import numpy as np

from armtwin.models import atomic
from armtwin.models.arm import Arm, arm_from_table, read_arm
from armtwin.models.errors import InputError, shown
from armtwin.models.importers.log import MOST_JOINTS, JointLog
from armtwin.models.motion.model_file import bare_model, compiled, joint_names, read_model
from armtwin.models.recordings.recording import SCHEMA, Recording, make_samples
from armtwin.models.recordings.writer import arm_table, write_recording
from armtwin.models.validation import ArmTable

# The length that links are given where nobody says how long they are.
UNKNOWN_LINK_MM = 100.0
_MODELS = (".xml", ".urdf")
_MAX_MODEL_BYTES = 1 << 24


def write_import(folder: Path, log: JointLog, arm: Path | None = None) -> tuple[str, ...]:
    """Write `recording.json` and `samples.csv`; return notes on what the arm was taken for.

    `arm` is an arm file, a twin, or a model of the arm (MJCF, URDF), which is copied. Raises `InputError` where it has
    another number of joints.
    """
    table, model, notes = _arm(log, arm)
    with atomic.folder_aside(folder) as aside:
        if log.motion == "settled":
            write_recording(aside, _settled(log, table))
        else:
            header: dict[str, Any] = {"schema": SCHEMA, "arm": table, "motion": "moving"}
            if log.clock == "synthetic":
                header["clock"] = "synthetic"
            atomic.write_json(aside / "recording.json", header)
            atomic.write_text(aside / "samples.csv", moving_csv(log))
        if model is not None:
            shutil.copyfile(model, aside / model.name)
    return notes


def moving_csv(log: JointLog) -> str:
    """Return `samples.csv` of a moving recording; what was not measured is an empty cell."""
    n = len(log.joints)
    columns = ["sample", "time_s", "trajectory", *(f"theta{i + 1}_cmd_rad" for i in range(n))]
    columns += [f"theta{i + 1}_meas_rad" for i in range(n)]
    blocks = [log.q_cmd, log.q_meas]
    for ending, values in log.extras.items():
        columns += [f"theta{i + 1}_{ending}" for i in range(n)]
        blocks.append(values)
    if log.commanded_s is not None:
        columns.append("commanded_s")
        blocks.append(log.commanded_s[:, None])
    numbers = np.concatenate(blocks, axis=1)
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(columns)
    for row in range(len(log)):
        cells = ["" if np.isnan(value) else repr(float(value)) for value in numbers[row]]
        writer.writerow([row, repr(float(log.time_s[row])), str(log.trajectory[row]), *cells])
    return out.getvalue()


def _arm(log: JointLog, arm: Path | None) -> tuple[dict[str, Any], Path | None, tuple[str, ...]]:
    n = len(log.joints)
    if arm is None:
        if n > MOST_JOINTS["settled"]:
            raise InputError(f"--arm: {n} joints need the arm's model (.xml, .urdf); or choose fewer with --joints")
        note = f"no --arm: every link is called {UNKNOWN_LINK_MM:g} mm, so only angles mean something, no millimetres"
        return arm_table(Arm("imported", np.full(n, UNKNOWN_LINK_MM), np.zeros(2))), None, (note,)
    if arm.suffix.lower() in _MODELS:
        if not arm.is_file():
            raise InputError(f"{arm}: no such file; --arm takes an arm.toml, a twin.toml, or a model (.xml, .urdf)")
        if log.motion == "settled":
            raise InputError(f"{arm.name}: poses at rest need link lengths; give an arm.toml")
        if arm.stat().st_size > _MAX_MODEL_BYTES:
            raise InputError(f"{arm.name}: larger than {_MAX_MODEL_BYTES} bytes")
        joints = _joints_of(arm, log)
        pairs = (name if name == own else f"{name} ({own})" for name, own in zip(joints, log.joints, strict=True))
        note = f"the arm is {arm.name}; its joints are {', '.join(pairs)}"
        return {"name": arm.stem, "model": arm.name, "joints": list(joints)}, arm, (note,)
    read = read_arm(arm)
    if read.n_joints != n:
        raise InputError(f"{arm.name}: has {read.n_joints} joints, the log {n} ({', '.join(log.joints)}); see --joints")
    return arm_table(read), None, ()


def _joints_of(model: Path, log: JointLog) -> tuple[str, ...]:
    """Return what the model calls the log's joints: their own names, or those of its hinges where it has as many."""
    hinges = joint_names(compiled(bare_model(read_model(model), model.name), model.name))
    strange = [name for name in log.joints if name not in hinges]
    if not strange:
        return log.joints
    if len(hinges) == len(log.joints):
        return tuple(hinges)
    raise InputError(
        f"{model.name}: has no joint '{shown(strange[0])}', which the log has; its {len(hinges)} are "
        f"{', '.join(map(shown, hinges))}: choose those of the log with --joints"
    )


def _settled(log: JointLog, table: dict[str, Any]) -> Recording:
    arm = arm_from_table(ArmTable.model_validate(table))
    return Recording(
        arm=arm,
        sample=make_samples(len(log)),
        time_s=log.time_s,
        trajectory=log.trajectory,
        q_cmd=log.q_cmd,
        q_meas=log.q_meas,
        commanded_s=log.commanded_s,
    )
