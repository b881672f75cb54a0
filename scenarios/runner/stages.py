"""The stages of a run, in their order."""

from __future__ import annotations

from scenarios.runner import camera
from scenarios.runner.run import Stage

STAGES: dict[str, Stage] = {
    "board": Stage("Chessboard views", (), camera.take_board_views),
    "camera": Stage("Camera calibration", ("board",), camera.calibrate),
}
