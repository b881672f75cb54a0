"""The stages of a run, in their order."""

from __future__ import annotations

from scenarios.runner import calibration, camera, capture, gauges, measure, report, results, validation
from scenarios.runner.run import Stage

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
    "results": Stage("Results", ("gauges", "validation"), results.gather),
    "report": Stage("Report", ("results",), report.write_report),
}
