"""Other programs' camera files, one format a file; nothing of theirs is known elsewhere.

A format says whether a file is its own (`recognises`), and makes a `Calibration` of it (`read`); `calibration.py` turns
that into a camera and holds what all formats have in common. `models/camera_files.py` is the door.
"""

from armtwin.models.camera_formats.calibration import Calibration
from armtwin.models.camera_formats.formats import read_calibration

__all__ = ["Calibration", "read_calibration"]
