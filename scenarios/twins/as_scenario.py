"""A twin where a scenario is asked for: the bench that was measured, with the paper's trajectories to run on it."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np

from armtwin.models.arm import nominal_arm
from armtwin.models.camera import Camera
from armtwin.models.camera_files import nominal_camera
from armtwin.models.errors import InputError
from armtwin.models.twin import Twin

# Two cameras of which no coefficient differs by more than this share are one.
_SAME = 1e-6
_TRAJECTORIES = {
    "circle_15": {"kind": "circle", "radius_mm": 15.0},
    "circle_25": {"kind": "circle", "radius_mm": 25.0},
    "line": {"kind": "line", "start_mm": [-145.0, 25.0], "end_mm": [-115.0, 45.0]},
}


def scenario_table(twin: Twin, file: str) -> dict[str, Any]:
    """Return the tables of a scenario (`armtwin.scenario/1`) whose bench is the twin.

    Raises `InputError` where a scenario cannot say what the twin is: another arm than the drawing's, another lens.
    """
    drawn = nominal_arm()
    if twin.arm.name != drawn.name or not np.allclose(twin.arm.link_lengths_mm, drawn.link_lengths_mm):
        raise InputError(
            f"{file}: the twin of another arm, '{twin.arm.name}' of {twin.arm.n_joints} joints: the paths of a run "
            f"are those of '{drawn.name}' as it is drawn; take it through a plan of its own with armtwin simulate"
        )
    table: dict[str, Any] = {
        "schema": "armtwin.scenario/1",
        "title": f"The twin {file}"[:200],
        "geometry": {
            "length_errors_mm": twin.deviation.lengths_mm.tolist(),
            "joint_errors_rad": twin.deviation.joints_rad.tolist(),
        },
        "bench": {
            "base_in_board_mm": twin.base_in_board_mm[:2].tolist(),
            "gravity_m_s2": twin.arm.gravity_m_s2.tolist(),
        },
        "trajectories": _TRAJECTORIES,
        "effects": [{"name": effect.effect, **effect.site.keys, **effect.parameters} for effect in twin.effects],
    }
    if twin.camera is not None:
        table["bench"]["arm_plane_z_mm"] = float(twin.base_in_board_mm[2])
        table["camera"] = _moved(twin.camera, file)
    return table


def _moved(camera: Camera, file: str) -> dict[str, list[float]]:
    """Return where the camera stands against Table 2's; raises `InputError` where it is another camera."""
    nominal = nominal_camera()
    same = (
        (camera.image_width, camera.image_height) == (nominal.image_width, nominal.image_height)
        and camera.lens.model == nominal.lens.model
        and np.allclose(camera.K, nominal.K, rtol=_SAME)
        and np.allclose(camera.lens.coefficients, nominal.lens.coefficients, rtol=_SAME, atol=_SAME)
    )
    if not same:
        raise InputError(
            f"{file}: a scenario films with Table 2's lens, this twin has a camera of its own; use armtwin simulate"
        )
    rotation = camera.R_board_camera @ nominal.R_board_camera.T
    turn = np.asarray(cv2.Rodrigues(rotation)[0], dtype=float).ravel()
    shift = camera.t_board_camera_mm - rotation @ nominal.t_board_camera_mm
    return {"turn_rad": turn.tolist(), "shift_mm": shift.tolist()}
