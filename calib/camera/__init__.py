"""Camera calibration from photographs of a chessboard, with its uncertainty and advice."""

from armtwin.calib.camera.advice import Advice
from armtwin.calib.camera.board import Board
from armtwin.calib.camera.corners import Corners, find_corners
from armtwin.calib.camera.coverage import Coverage
from armtwin.calib.camera.fit import CameraCalibration, calibrate_camera
from armtwin.calib.camera.models import MODELS, CameraModel
from armtwin.calib.camera.uncertainty import Uncertainty

__all__ = [
    "MODELS",
    "Advice",
    "Board",
    "CameraCalibration",
    "CameraModel",
    "Corners",
    "Coverage",
    "Uncertainty",
    "calibrate_camera",
    "find_corners",
]
