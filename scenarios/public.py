"""What the commands do, as functions: `import armtwin` offers them under the same names."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Literal, overload

from armtwin.calib.arm import algorithm_1, least_squares
from armtwin.calib.arm.calibration import ArmCalibration
from armtwin.calib.camera.board import Board
from armtwin.calib.camera.fit import CameraCalibration
from armtwin.calib.camera.images import find_images
from armtwin.calib.diagnosis import diagnosis
from armtwin.calib.motion.diagnosis import MotionDiagnosis, diagnose_motion
from armtwin.models import twin
from armtwin.models.arm import Arm
from armtwin.models.bench import Bench
from armtwin.models.errors import InputError
from armtwin.models.export import mjcf, onto_urdf, urdf
from armtwin.models.export.held import Held
from armtwin.models.moving_twin import MovingTwin, is_moving_twin, read_moving_twin
from armtwin.models.plan import Plan, read_plan
from armtwin.models.recordings.moving import MovingRecording
from armtwin.models.recordings.moving_reader import is_moving, read_moving
from armtwin.models.recordings.recording import Recording
from armtwin.models.twin import Twin
from armtwin.models.wanted_path import WantedPath, wanted_path
from armtwin.scenarios.benches import door
from armtwin.scenarios.benches.spec import bench_spec
from armtwin.scenarios.camera_calibration.job import AUTOMATIC, calibrate_views, check_model, collect
from armtwin.scenarios.diagnosis import findings
from armtwin.scenarios.diagnosis.measured import measured
from armtwin.scenarios.motion.twin import moving_twin_of
from armtwin.scenarios.plans import load_plan
from armtwin.scenarios.report.data import RunData
from armtwin.scenarios.runner.experiment import run_experiment
from armtwin.scenarios.twins import correction, simulation
from armtwin.scenarios.twins.correction import Correction
from armtwin.scenarios.twins.moving_simulation import RATE_HZ, simulate_moving
from armtwin.sim.motion.export import MovingHeld, export_moving_mjcf

PathLike = str | os.PathLike[str]


def read_recording(
    folder: PathLike, *, progress: Callable[[str], None] = lambda _: None
) -> Recording | MovingRecording:
    """Read a recording folder, of poses at rest or of a moving arm.

    Where only frames of poses stand in it, the markers are measured in them. `progress` is told what is being done.
    Raises `RecordingError` that names the file, the key or row, and the remedy.

    >>> log = armtwin.read_recording("logs/wave")
    >>> len(log), log.motions
    (2000, ('chirp', 'steps', 'slow', 'stairs'))
    """
    path = Path(folder)
    return read_moving(path) if is_moving(path) else measured(path, progress)


def calibrate(
    recording: Recording | MovingRecording,
    trajectories: Sequence[str] | None = None,
    *,
    method: Literal["least-squares", "algorithm-1"] = "least-squares",
) -> ArmCalibration:
    """Calibrate the arm's link lengths and joint zeros on the named trajectories.

    By default on all that the recording does not hold out; by least squares on every marker, or by the paper's
    Algorithm 1 on A and F. Raises `InputError` for poses that say too little, and for a moving arm, whose link lengths
    are taken as they are.
    """
    if isinstance(recording, MovingRecording):
        raise InputError("a recording of a moving arm is diagnosed, not calibrated; poses at rest are wanted")
    return {"least-squares": least_squares, "algorithm-1": algorithm_1}[method].calibrate(recording, trajectories)


@overload
def diagnose(recording: Recording, *, progress: Callable[[str], None] = ...) -> diagnosis.Diagnosis: ...
@overload
def diagnose(recording: MovingRecording, *, progress: Callable[[str], None] = ...) -> MotionDiagnosis: ...
def diagnose(
    recording: Recording | MovingRecording, *, progress: Callable[[str], None] = lambda _: None
) -> diagnosis.Diagnosis | MotionDiagnosis:
    """Name what the twin of a recording still gets wrong, and measure the gain on poses or motions that it did not fit.

    `progress` is told what is being done. Raises `RecordingError` where the recording cannot decide anything.

    >>> found = armtwin.diagnose(armtwin.read_recording("logs/wave"))
    >>> found.verdict, [(cause.effect, cause.joint) for cause in found.causes]
    ('named', [('servo_lag', 2)])
    >>> round(found.causes[0].parameters["time_constant_s"].value, 2)
    0.08
    >>> sorted(found.columns())
    ['effect', 'joint', 'parameter', 'std', 'value']
    """
    if isinstance(recording, MovingRecording):
        return diagnose_motion(recording, progress)
    return diagnosis.diagnose(recording, progress)


def run(scenario: PathLike, out: PathLike, *, workers: Literal[1, 2] = 2, quiet: bool = True) -> RunData:
    """Run a scenario, by name or file, in the folder `out`, or go on with the run that is there.

    Returns its results, truth and recordings. Workers are processes that import the calling script anew: call it below
    `if __name__ == "__main__":`. Raises `InputError`, or `JobError` where a stage fails.
    """
    return RunData(run_experiment(os.fspath(scenario), Path(out), workers, quiet=quiet).out)


def read_twin(path: PathLike) -> Twin | MovingTwin:
    """Read a twin file (`twin.toml`, as `diagnose` writes it from the command line); raises `InputError`.

    The twin of a moving arm that is given by a model has that file beside it.
    """
    return read_moving_twin(Path(path)) if is_moving_twin(Path(path)) else twin.read_twin(Path(path))


@overload
def twin_of(found: diagnosis.Diagnosis) -> Twin: ...
@overload
def twin_of(found: MotionDiagnosis) -> MovingTwin: ...
def twin_of(found: diagnosis.Diagnosis | MotionDiagnosis) -> Twin | MovingTwin:
    """Return the extended twin that a diagnosis found: the calibrated arm with every effect of the final model.

    Of a moving arm, with every cause that MuJoCo can be given.
    """
    return moving_twin_of(found) if isinstance(found, MotionDiagnosis) else findings.twin_of(found)


def calibrate_camera(
    photographs: Sequence[PathLike], *, board: str = "9x6", square_mm: float = 25.0, model: str = AUTOMATIC
) -> CameraCalibration:
    """Calibrate a camera from photographs (files, folders, patterns) of a chessboard of `board` inner corners.

    `model` is one of the command's `--model`. Raises `InputError` where the photographs say too little.
    """
    images = find_images([Path(photograph) for photograph in photographs])
    check_model(model)
    seen = collect(images, Board.parse(board, square_mm), window_px=0)
    return calibrate_views(seen, images, model=model).calibration


@overload
def export_mjcf(twin: Twin, path: PathLike) -> Held: ...
@overload
def export_mjcf(twin: MovingTwin, path: PathLike) -> MovingHeld: ...
def export_mjcf(twin: Twin | MovingTwin, path: PathLike) -> Held | MovingHeld:
    """Write a twin as MJCF that plain MuJoCo loads, and beside it what MJCF cannot hold; return what is held.

    >>> twin = armtwin.twin_of(armtwin.diagnose(armtwin.read_recording("logs/wave")))
    >>> held = armtwin.export_mjcf(twin, "arm.xml")
    >>> [name for name, *_ in held.held], held.not_held
    (['servo_lag'], ())
    """
    if isinstance(twin, MovingTwin):
        return export_moving_mjcf(twin.causes, twin.arm, Path(path), twin.zeros_rad)
    return mjcf.export_mjcf(twin, Path(path))


def export_urdf(
    twin: Twin | MovingTwin,
    path: PathLike,
    *,
    onto: PathLike | None = None,
    joints: Sequence[str] | None = None,
    tip: str | None = None,
) -> Held:
    """Write a twin as URDF, or mend the URDF `onto` with it; `joints` and `tip` name parts of that.

    Raises `InputError` for a URDF that is not of this arm.
    """
    if isinstance(twin, MovingTwin):
        raise InputError("no URDF holds the drives of a moving arm's twin; export it as MJCF")
    if onto is None:
        return urdf.export_urdf(twin, Path(path))
    return onto_urdf.export_onto_urdf(twin, Path(onto), Path(path), joints, tip)


def correct(twin: Twin | MovingTwin, plan: PathLike | WantedPath) -> Correction:
    """Return commands that bring the arm where `plan` wants it: a CSV, `paper`, or a path made in memory.

    Raises `InputError` for a plan that cannot be read, or of which no point can be reached, and for a moving twin.
    """
    if isinstance(twin, MovingTwin):
        raise InputError("commands are corrected for poses at rest; this is a moving arm's twin")
    wanted = plan if isinstance(plan, WantedPath) else wanted_path(os.fspath(plan), twin.arm)
    return correction.correct(twin, wanted)


@overload
def simulate(
    twin: Twin, plan: PathLike | Plan, *, noise: float | None = ..., seed: int = ..., held_out: tuple[str, ...] = ...
) -> Recording: ...
@overload
def simulate(
    twin: MovingTwin,
    plan: PathLike | Plan,
    *,
    noise: float | None = ...,
    seed: int = ...,
    held_out: tuple[str, ...] = ...,
    rate_hz: float = ...,
) -> MovingRecording: ...
def simulate(
    twin: Twin | MovingTwin,
    plan: PathLike | Plan,
    *,
    noise: float | None = None,
    seed: int = 0,
    held_out: tuple[str, ...] = (),
    rate_hz: float = RATE_HZ,
) -> Recording | MovingRecording:
    """Return what a bench that is as the twin says would record of `plan`: `paper`, a CSV, or one made in memory.

    `noise` is in px, or in rad for a twin without camera; `rate_hz` is how often a moving arm is commanded where the
    plan says no times. Raises `InputError` for a plan that cannot be read.

    >>> twin = armtwin.twin_of(armtwin.diagnose(armtwin.read_recording("logs/wave")))
    >>> log = armtwin.simulate(twin, "plan.csv", rate_hz=40.0)
    >>> len(log), log.motions
    (3, ('there', 'back'))
    """
    if isinstance(twin, MovingTwin):
        arm = twin.declared
        if not isinstance(plan, Plan):
            plan = load_plan(os.fspath(plan), arm) if isinstance(arm, Arm) else read_plan(Path(plan), arm.n_joints)
        return simulate_moving(twin, plan, rate_hz=rate_hz, noise_rad=noise, seed=seed, held_out=held_out)
    wanted = plan if isinstance(plan, Plan) else load_plan(os.fspath(plan), twin.arm)
    return simulation.simulate(twin, wanted, noise=noise, seed=seed, held_out=held_out)


def open_bench(
    bench: PathLike,
    *,
    token: str | None = None,
    speed: float | None = None,
    hang_by: Callable[[float], None] | None = None,
) -> Bench:
    """Return a bench, a context manager that connects it and closes it.

    `bench` is `simulated`, a scenario, `emulated` (at `speed` times real time), a bench file, or the address of a
    served bench, which asks for a `token`. `hang_by` hangs a mass of so many kg at the tip of a hardware bench, or asks
    someone to. Raises `InputError` for what is no bench.
    """
    return door.open_bench(bench_spec(os.fspath(bench), token=token, speed=speed), hang_by=hang_by)
