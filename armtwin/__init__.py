"""armtwin: a simulation-first digital twin of a planar servo arm watched by one webcam.

    import armtwin

    recording = armtwin.read_recording("recordings/first")
    print(armtwin.calibrate(recording).deviation)
    found = armtwin.diagnose(recording)
    print(found.verdict)

    twin = armtwin.twin_of(found)
    armtwin.export_mjcf(twin, "arm.xml")
    print(armtwin.correct(twin, "path.csv").after_mm.max())

    with armtwin.open_bench("simulated") as bench:
        bench.move(q_cmd_rad)
        frame = bench.capture()

The names below stay; what they are made of is in the rooms (`armtwin.models`, `sim`, `calib`, `hardware`,
`scenarios`), for those who work on armtwin. A name is imported when it is first used.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from armtwin.calib.arm.calibration import ArmCalibration
    from armtwin.calib.camera.fit import CameraCalibration
    from armtwin.calib.diagnosis.diagnosis import Diagnosis
    from armtwin.calib.motion.diagnosis import MotionDiagnosis
    from armtwin.models.bench import Bench, BenchDescription, Frame
    from armtwin.models.errors import ArmtwinError, InputError, JobError, RecordingError
    from armtwin.models.export.held import Held
    from armtwin.models.importers.lerobot import read_lerobot
    from armtwin.models.importers.log import JointLog
    from armtwin.models.importers.mcap_bag import read_mcap
    from armtwin.models.importers.sage import read_sage
    from armtwin.models.importers.writing import write_import
    from armtwin.models.moving_twin import MovingTwin
    from armtwin.models.plan import Plan
    from armtwin.models.recordings.moving import ModelArm, MovingRecording
    from armtwin.models.recordings.recording import Recording
    from armtwin.models.twin import Twin
    from armtwin.models.wanted_path import WantedPath
    from armtwin.scenarios.public import (
        calibrate,
        calibrate_camera,
        correct,
        diagnose,
        export_mjcf,
        export_urdf,
        open_bench,
        read_recording,
        read_twin,
        run,
        simulate,
        twin_of,
    )
    from armtwin.scenarios.report.data import RunData
    from armtwin.scenarios.twins.correction import Correction
    from armtwin.sim.motion.export import MovingHeld

_PLACES = {
    "ArmCalibration": "calib.arm.calibration",
    "CameraCalibration": "calib.camera.fit",
    "Diagnosis": "calib.diagnosis.diagnosis",
    **dict.fromkeys(("Bench", "BenchDescription", "Frame"), "models.bench"),
    **dict.fromkeys(("ArmtwinError", "InputError", "JobError", "RecordingError"), "models.errors"),
    "Recording": "models.recordings.recording",
    "Held": "models.export.held",
    "MotionDiagnosis": "calib.motion.diagnosis",
    **dict.fromkeys(("ModelArm", "MovingRecording"), "models.recordings.moving"),
    "MovingHeld": "sim.motion.export",
    "MovingTwin": "models.moving_twin",
    "JointLog": "models.importers.log",
    "Plan": "models.plan",
    "read_lerobot": "models.importers.lerobot",
    "read_mcap": "models.importers.mcap_bag",
    "read_sage": "models.importers.sage",
    "write_import": "models.importers.writing",
    "Twin": "models.twin",
    "WantedPath": "models.wanted_path",
    "Correction": "scenarios.twins.correction",
    **dict.fromkeys(("calibrate", "diagnose", "open_bench", "read_recording", "read_twin", "run"), "scenarios.public"),
    **dict.fromkeys(
        ("calibrate_camera", "correct", "export_mjcf", "export_urdf", "simulate", "twin_of"), "scenarios.public"
    ),
    "RunData": "scenarios.report.data",
}

__all__ = [
    "ArmCalibration",
    "ArmtwinError",
    "Bench",
    "BenchDescription",
    "CameraCalibration",
    "Correction",
    "Diagnosis",
    "Frame",
    "Held",
    "InputError",
    "JobError",
    "JointLog",
    "ModelArm",
    "MotionDiagnosis",
    "MovingHeld",
    "MovingRecording",
    "MovingTwin",
    "Plan",
    "Recording",
    "RecordingError",
    "RunData",
    "Twin",
    "WantedPath",
    "calibrate",
    "calibrate_camera",
    "correct",
    "diagnose",
    "export_mjcf",
    "export_urdf",
    "open_bench",
    "read_lerobot",
    "read_mcap",
    "read_recording",
    "read_sage",
    "read_twin",
    "run",
    "simulate",
    "twin_of",
    "write_import",
]

if not TYPE_CHECKING:  # a type checker would take any name for one of these

    def __getattr__(name: str) -> object:
        if name not in _PLACES:
            raise AttributeError(f"module 'armtwin' has no attribute '{name}'; it offers {', '.join(__all__)}")
        from importlib import import_module

        value = globals()[name] = getattr(import_module(f"armtwin.{_PLACES[name]}"), name)
        return value

    def __dir__() -> list[str]:
        return sorted({*globals(), *__all__})
