"""What the commands do, as functions: `import armtwin` offers them under the same names."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Literal

from armtwin.calib.arm import algorithm_1, least_squares
from armtwin.calib.arm.calibration import ArmCalibration
from armtwin.calib.camera.board import Board
from armtwin.calib.camera.fit import CameraCalibration
from armtwin.calib.camera.images import find_images
from armtwin.calib.diagnosis import diagnosis
from armtwin.models import twin
from armtwin.models.bench import Bench
from armtwin.models.export import mjcf, onto_urdf, urdf
from armtwin.models.export.held import Held
from armtwin.models.plan import Plan
from armtwin.models.recordings.recording import Recording
from armtwin.models.twin import Twin
from armtwin.models.wanted_path import WantedPath, wanted_path
from armtwin.scenarios.benches import door
from armtwin.scenarios.benches.spec import bench_spec
from armtwin.scenarios.camera_calibration.job import AUTOMATIC, calibrate_views, check_model, collect
from armtwin.scenarios.diagnosis import findings
from armtwin.scenarios.diagnosis.measured import measured
from armtwin.scenarios.plans import load_plan
from armtwin.scenarios.report.data import RunData
from armtwin.scenarios.runner.experiment import run_experiment
from armtwin.scenarios.twins import correction, simulation
from armtwin.scenarios.twins.correction import Correction

PathLike = str | os.PathLike[str]


def read_recording(folder: PathLike, *, progress: Callable[[str], None] = lambda _: None) -> Recording:
    """Read a recording folder; where only frames stand in it, the markers are measured in them.

    `progress` is told what is being done. Raises `RecordingError` that names the file, the key or row, and the remedy.
    """
    return measured(Path(folder), progress)


def calibrate(
    recording: Recording,
    trajectories: Sequence[str] | None = None,
    *,
    method: Literal["least-squares", "algorithm-1"] = "least-squares",
) -> ArmCalibration:
    """Calibrate the arm's link lengths and joint zeros on the named trajectories.

    By default on all that the recording does not hold out; by least squares on every marker, or by the paper's
    Algorithm 1 on A and F. Raises `InputError` for poses that say too little.
    """
    return {"least-squares": least_squares, "algorithm-1": algorithm_1}[method].calibrate(recording, trajectories)


def diagnose(recording: Recording, *, progress: Callable[[str], None] = lambda _: None) -> diagnosis.Diagnosis:
    """Name what the twin of a recording still gets wrong, and measure the gain on poses that it did not fit.

    `progress` is told what is being done. Raises `RecordingError` where the recording cannot decide anything.
    """
    return diagnosis.diagnose(recording, progress)


def run(scenario: PathLike, out: PathLike, *, workers: Literal[1, 2] = 2, quiet: bool = True) -> RunData:
    """Run a scenario, by name or file, in the folder `out`, or go on with the run that is there.

    Returns its results, truth and recordings. Workers are processes that import the calling script anew: call it below
    `if __name__ == "__main__":`. Raises `InputError`, or `JobError` where a stage fails.
    """
    return RunData(run_experiment(os.fspath(scenario), Path(out), workers, quiet=quiet).out)


def read_twin(path: PathLike) -> Twin:
    """Read a twin file (`twin.toml`, as `diagnose` writes it from the command line); raises `InputError`."""
    return twin.read_twin(Path(path))


def twin_of(found: diagnosis.Diagnosis) -> Twin:
    """Return the extended twin that a diagnosis found: the calibrated arm with every effect of the final model."""
    return findings.twin_of(found)


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


def export_mjcf(twin: Twin, path: PathLike) -> Held:
    """Write a twin as MJCF that plain MuJoCo loads, and beside it what MJCF cannot hold; return what is held."""
    return mjcf.export_mjcf(twin, Path(path))


def export_urdf(
    twin: Twin,
    path: PathLike,
    *,
    onto: PathLike | None = None,
    joints: Sequence[str] | None = None,
    tip: str | None = None,
) -> Held:
    """Write a twin as URDF, or mend the URDF `onto` with it; `joints` and `tip` name parts of that.

    Raises `InputError` for a URDF that is not of this arm.
    """
    if onto is None:
        return urdf.export_urdf(twin, Path(path))
    return onto_urdf.export_onto_urdf(twin, Path(onto), Path(path), joints, tip)


def correct(twin: Twin, plan: PathLike | WantedPath) -> Correction:
    """Return commands that bring the arm where `plan` wants it: a CSV, `paper`, or a path made in memory.

    Raises `InputError` for a plan that cannot be read, or of which no point can be reached.
    """
    wanted = plan if isinstance(plan, WantedPath) else wanted_path(os.fspath(plan), twin.arm)
    return correction.correct(twin, wanted)


def simulate(
    twin: Twin,
    plan: PathLike | Plan,
    *,
    noise: float | None = None,
    seed: int = 0,
    held_out: tuple[str, ...] = (),
) -> Recording:
    """Return what a bench that is as the twin says would record of `plan`: `paper`, a CSV, or one made in memory.

    `noise` is in px, or in rad for a twin without camera. Raises `InputError` for a plan that cannot be read.
    """
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
