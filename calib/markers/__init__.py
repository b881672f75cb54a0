"""Marker measurement: the paper's detector and the sub-pixel one, and which disc is which marker."""

from armtwin.calib.markers.bound import centre_bound
from armtwin.calib.markers.detect import detect
from armtwin.calib.markers.disc import DetectorConfig, Disc, Method
from armtwin.calib.markers.identify import identify
from armtwin.calib.markers.paper import PaperStages, paper_stages
from armtwin.calib.markers.reading import MarkerReading
from armtwin.calib.markers.recording import measure_frames, measure_recording, with_markers

__all__ = [
    "DetectorConfig",
    "Disc",
    "MarkerReading",
    "Method",
    "PaperStages",
    "centre_bound",
    "detect",
    "identify",
    "measure_frames",
    "measure_recording",
    "paper_stages",
    "with_markers",
]
