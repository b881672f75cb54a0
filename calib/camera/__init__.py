"""Camera calibration from photographs of a chessboard, with its uncertainty and advice."""

from calib.camera.advice import Advice
from calib.camera.board import Board
from calib.camera.corners import Corners, find_corners
from calib.camera.coverage import Coverage
from calib.camera.fit import CameraCalibration, calibrate_camera
from calib.camera.uncertainty import INTRINSICS, Uncertainty

__all__ = [
    "INTRINSICS",
    "Advice",
    "Board",
    "CameraCalibration",
    "Corners",
    "Coverage",
    "Uncertainty",
    "calibrate_camera",
    "find_corners",
]
