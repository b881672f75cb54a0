"""The stages of a run, in their order."""

from __future__ import annotations

from armtwin.scenarios.runner import (
    calibration,
    camera,
    capture,
    diagnosis,
    gain,
    gauges,
    measure,
    report,
    results,
    validation,
)
from armtwin.scenarios.runner.stage import Stage

STAGES: dict[str, Stage] = {
    "capture_before": Stage("Trajectories", (), capture.capture_before),
    "board": Stage("Chessboard views", (), camera.take_board_views),
    "camera": Stage("Camera calibration", ("board",), camera.calibrate),
    "gauges": Stage("Length gauges", ("camera",), gauges.evaluate_gauges),
    "measure_before": Stage("Markers in the frames", ("camera", "capture_before"), measure.measure_before),
    "calibration": Stage("Arm calibrations", ("measure_before",), calibration.calibrate_arm),
    "capture_after": Stage("Corrected line", ("calibration",), capture.capture_after),
    "measure_after": Stage("Markers in its frames", ("camera", "capture_after"), measure.measure_after),
    "validation": Stage("Validation", ("measure_before", "measure_after"), validation.validate),
    "diagnose": Stage("Diagnosis and extended twin", ("measure_before",), diagnosis.diagnose_arm),
    "capture_extended": Stage("Line by the extended twin", ("diagnose",), capture.capture_extended),
    "measure_extended": Stage("Markers in its frames", ("camera", "capture_extended"), measure.measure_extended),
    "gain": Stage("Gain", ("validation", "diagnose", "measure_extended"), gain.measure_gain),
    "results": Stage("Results", ("gauges", "gain"), results.gather, ("results.json", "truth.json")),
    "report": Stage("Report", ("results",), report.write_report, ("report.html",)),
}
