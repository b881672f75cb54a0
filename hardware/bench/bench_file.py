"""The bench file: everything that is particular to one bench, read and checked before anything is opened or moved."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from armtwin.hardware.bench.servo_map import ServoMap
from armtwin.hardware.bench.tables import BenchTable, CameraSettings, JointTable, MotionTable, QualityTable, SettleTable
from armtwin.models.arm import Arm, nominal_arm, read_arm
from armtwin.models.bench import BenchDescription
from armtwin.models.camera import Camera, check_plane
from armtwin.models.camera_files import read_camera
from armtwin.models.errors import InputError
from armtwin.models.joint_limits import JointLimits
from armtwin.models.toml_reader import read_toml
from armtwin.models.validation import check, short

Array = NDArray[np.float64]

_SOURCES = "a device like /dev/video0, an MJPEG stream (http:// or https://) or a video file beside the bench file"


@dataclass(frozen=True, eq=False)
class BenchSetup:
    """A bench as its file describes it.

    Attributes:
        arm: the nominal arm.
        camera: the calibrated camera with the board's pose.
        port: the Arduino's serial port.
        servo_map, limits: of the joints, in their order.
        rest_rad: (n,) the pose that a person puts the limp arm into when the picture does not tell where it stands.
        camera_settings, motion, settle, quality: the tables of the same names.

    """

    arm: Arm
    camera: Camera
    arm_plane_z_mm: float
    port: str
    servo_map: ServoMap
    limits: JointLimits
    rest_rad: Array
    camera_settings: CameraSettings
    motion: MotionTable
    settle: SettleTable
    quality: QualityTable

    @property
    def description(self) -> BenchDescription:
        """What the bench says of itself; pulses are what a command becomes on it."""
        return BenchDescription(
            kind="hardware",
            arm=self.arm,
            camera=self.camera,
            arm_plane_z_mm=self.arm_plane_z_mm,
            limits=self.limits,
            actuation=self.servo_map.as_table(),
        )


def read_bench(path: Path) -> BenchSetup:
    """Read a bench file; raises `InputError` that names the file and the key.

    Files that it names (`arm`, `camera.calibration`, a video) lie in its folder or below.
    """
    table = check(BenchTable, read_toml(path), path.name)
    arm = nominal_arm() if table.arm is None else read_arm(beside(path, "arm", table.arm))
    if arm.n_joints != len(table.joints):
        named = "the paper's arm, since no arm is named," if table.arm is None else f"'{table.arm}'"
        raise InputError(
            f"{path.name}: arm: {named} has {arm.n_joints} joints, {len(table.joints)} tables [[joints]] are there; "
            "name the arm's file, or write one table for each of its joints"
        )
    _check_limits(arm, table.joints, path.name)
    camera = read_camera(beside(path, "camera.calibration", table.camera.calibration))
    if not camera.t_board_camera_mm.any():
        raise InputError(
            f"{path.name}: camera.calibration: '{table.camera.calibration}' has no pose of the board "
            "(board_to_camera_rotation, board_to_camera_translation_mm); take it with armtwin calibrate-camera"
        )
    try:
        check_plane(camera, table.camera.arm_plane_z_mm)
    except InputError as error:
        raise InputError(f"{path.name}: camera.{error}") from None
    return setup_of(_with_video_beside(table, path), arm, camera)


def read_camera_tables(path: Path) -> tuple[CameraSettings, QualityTable]:
    """Read a bench file for its camera alone, whose calibration need not be there yet; raises `InputError`."""
    table = check(BenchTable, read_toml(path), path.name)
    return _with_video_beside(table, path).camera, table.quality


def _with_video_beside(table: BenchTable, path: Path) -> BenchTable:
    """Return the table with the path of a video file as it can be opened from here."""
    if table.camera.source.startswith(("/dev/", "http://", "https://")):
        return table
    video = str(_video(path, table.camera.source))
    return table.model_copy(update={"camera": table.camera.model_copy(update={"source": video})})


def _check_limits(arm: Arm, joints: Sequence[JointTable], file: str) -> None:
    """Raise `InputError` where the bench lets a joint turn further than the arm's drawing does."""
    if arm.joint_limits_rad is None:
        return
    for label, joint, (low, high) in zip(arm.joint_labels, joints, arm.joint_limits_rad.tolist(), strict=True):
        if joint.min_rad < low or joint.max_rad > high:
            raise InputError(
                f"{file}: {label}: min_rad {joint.min_rad:g} to max_rad {joint.max_rad:g} goes beyond the arm file's "
                f"joint_limits_rad, {low:g} to {high:g}; narrow it"
            )


def setup_of(table: BenchTable, arm: Arm, camera: Camera) -> BenchSetup:
    """Return the setup that a validated table describes, with the files that it names already read."""
    joints = table.joints
    return BenchSetup(
        arm=arm,
        camera=camera,
        arm_plane_z_mm=table.camera.arm_plane_z_mm,
        port=table.serial.port,
        servo_map=ServoMap(
            servo=np.array([joint.servo - 1 for joint in joints]),
            zero_us=np.array([joint.zero_us for joint in joints]),
            us_per_rad=np.array([joint.direction * joint.us_per_rad for joint in joints]),
        ),
        limits=JointLimits(
            min_rad=np.array([joint.min_rad for joint in joints]),
            max_rad=np.array([joint.max_rad for joint in joints]),
            max_step_rad=table.motion.max_step_rad,
            labels=arm.joint_labels,
        ),
        rest_rad=np.array(table.motion.rest_rad or [0.0] * len(joints)),
        camera_settings=table.camera,
        motion=table.motion,
        settle=table.settle,
        quality=table.quality,
    )


def _video(path: Path, name: str) -> Path:
    if "://" in name:
        raise InputError(f"{path.name}: camera.source: found {short(name)}; {_SOURCES} is wanted")
    try:
        return beside(path, "camera.source", name)
    except InputError as error:
        raise InputError(f"{error}; {_SOURCES} is wanted") from None


def beside(path: Path, key: str, name: str) -> Path:
    """Return the file `name` in the folder of `path` or below it; raises `InputError` for one that leaves it."""
    folder = path.parent.resolve()
    if not name.isprintable():  # the system takes no path with a zero byte
        raise InputError(f"{path.name}: {key}: {name!r} is no name of a file")
    target = (folder / name).resolve()
    if not target.is_relative_to(folder):
        raise InputError(f"{path.name}: {key}: '{name}' leaves the bench file's folder; copy the file beside it")
    if not target.is_file():
        raise InputError(f"{path.name}: {key}: no file '{name}' beside the bench file")
    return target
