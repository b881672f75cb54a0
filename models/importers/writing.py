"""An imported log written as a recording folder."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from armtwin.models import atomic
from armtwin.models.arm import Arm, read_arm
from armtwin.models.errors import InputError, shown
from armtwin.models.importers.log import MOST_JOINTS, JointLog
from armtwin.models.motion.model_file import bare_model, compiled, joint_names, read_model
from armtwin.models.recordings.moving import ModelArm, MovingRecording
from armtwin.models.recordings.moving_writer import write_moving_recording
from armtwin.models.recordings.recording import Recording, make_samples
from armtwin.models.recordings.writer import write_recording

# The length that links are given where nobody says how long they are.
UNKNOWN_LINK_MM = 100.0
_MODELS = (".xml", ".urdf")
_MAX_MODEL_BYTES = 1 << 24


def write_import(folder: Path, log: JointLog, arm: Path | None = None) -> tuple[str, ...]:
    """Write `recording.json` and `samples.csv`; return notes on what the arm was taken for.

    `arm` is an arm file, a twin, or a model of the arm (MJCF, URDF), which is copied. Raises `InputError` where it has
    another number of joints.
    """
    made, notes = _arm(log, arm)
    if isinstance(made, ModelArm) or log.motion == "moving":
        write_moving_recording(folder, _moving(log, made))
    else:
        with atomic.folder_aside(folder) as aside:
            write_recording(aside, _settled(log, made))
    return notes


def _arm(log: JointLog, arm: Path | None) -> tuple[Arm | ModelArm, tuple[str, ...]]:
    n = len(log.joints)
    if arm is None:
        if n > MOST_JOINTS["settled"]:
            raise InputError(f"--arm: {n} joints need the arm's model (.xml, .urdf); or choose fewer with --joints")
        note = f"no --arm: every link is called {UNKNOWN_LINK_MM:g} mm, so only angles mean something, no millimetres"
        return Arm("imported", np.full(n, UNKNOWN_LINK_MM), np.zeros(2)), (note,)
    if arm.suffix.lower() in _MODELS:
        if not arm.is_file():
            raise InputError(f"{arm}: no such file; --arm takes an arm.toml, a twin.toml, or a model (.xml, .urdf)")
        if log.motion == "settled":
            raise InputError(f"{arm.name}: poses at rest need link lengths; give an arm.toml")
        if arm.stat().st_size > _MAX_MODEL_BYTES:
            raise InputError(f"{arm.name}: larger than {_MAX_MODEL_BYTES} bytes")
        joints = _joints_of(arm, log)
        pairs = (name if name == own else f"{name} ({own})" for name, own in zip(joints, log.joints, strict=True))
        return ModelArm(arm.stem, joints, arm), (f"the arm is {arm.name}; its joints are {', '.join(pairs)}",)
    read = read_arm(arm)
    if read.n_joints != n:
        raise InputError(f"{arm.name}: has {read.n_joints} joints, the log {n} ({', '.join(log.joints)}); see --joints")
    return read, ()


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


def _settled(log: JointLog, arm: Arm) -> Recording:
    return Recording(
        arm=arm,
        sample=make_samples(len(log)),
        time_s=log.time_s,
        trajectory=log.trajectory,
        q_cmd=log.q_cmd,
        q_meas=log.q_meas,
        commanded_s=log.commanded_s,
    )


def _moving(log: JointLog, arm: Arm | ModelArm) -> MovingRecording:
    return MovingRecording(
        arm=arm,
        time_s=log.time_s,
        trajectory=log.trajectory,
        q_cmd=log.q_cmd,
        q_meas=log.q_meas,
        commanded_s=log.commanded_s,
        extras=log.extras,
        clock=log.clock,
    )
