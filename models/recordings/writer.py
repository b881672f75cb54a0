"""Writing recordings; floats are written so that they read back the same."""

from __future__ import annotations

import csv
import io
import math
from pathlib import Path
from typing import Any

import numpy as np

from armtwin.models import atomic
from armtwin.models.arm import Arm
from armtwin.models.camera import Camera
from armtwin.models.recordings.recording import OPTIONAL_COLUMNS, SCHEMA, Recording


def write_recording(folder: Path, recording: Recording) -> None:
    """Write `recording.json` and `samples.csv` into `folder`, each atomically; what else is there is left alone."""
    atomic.write_json(folder / "recording.json", header_of(recording))
    atomic.write_text(folder / "samples.csv", samples_csv(recording))


def header_of(recording: Recording) -> dict[str, Any]:
    """Return the content of `recording.json`."""
    header: dict[str, Any] = {"schema": SCHEMA, "arm": arm_table(recording.arm)}
    if recording.camera is not None:
        header["camera"] = camera_table(recording.camera)
        header["arm_plane_z_mm"] = recording.arm_plane_z_mm
    if recording.pixel_noise_px is not None:
        header["pixel_noise_px"] = recording.pixel_noise_px
    if recording.held_out:
        header["held_out"] = list(recording.held_out)
    return header


def arm_table(arm: Arm) -> dict[str, Any]:
    """Return the `arm` table of a recording."""
    table: dict[str, Any] = {
        "name": arm.name,
        "link_lengths_mm": arm.link_lengths_mm.tolist(),
        "gravity_m_s2": arm.gravity_m_s2.tolist(),
    }
    if arm.link_masses_kg is not None:
        table["link_masses_kg"] = arm.link_masses_kg.tolist()
    if arm.tip_mass_kg is not None:
        table["tip_mass_kg"] = arm.tip_mass_kg
    if arm.joints is not None:
        table["joints"] = list(arm.joints)
    if arm.joint_limits_rad is not None:
        table["joint_limits_rad"] = arm.joint_limits_rad.tolist()
    return table


def camera_table(camera: Camera) -> dict[str, Any]:
    """Return the `camera` table of a recording."""
    return {
        "image_width": camera.image_width,
        "image_height": camera.image_height,
        "camera_matrix": camera.K.tolist(),
        "distortion_model": camera.lens.ros_model,
        "distortion_coefficients": camera.lens.coefficients.tolist(),
        "board_to_camera_rotation": camera.R_board_camera.tolist(),
        "board_to_camera_translation_mm": camera.t_board_camera_mm.tolist(),
    }


def columns_of(recording: Recording) -> list[str]:
    """Return the header row of `samples.csv`."""
    n = recording.arm.n_joints
    columns = ["sample", "time_s", "trajectory", *(f"theta{i + 1}_cmd_rad" for i in range(n))]
    for name in recording.markers_px:
        columns += [f"{name}_u_px", f"{name}_v_px"]
    if recording.q_meas is not None:
        columns += [f"theta{i + 1}_meas_rad" for i in range(n)]
    return columns + [name for name in OPTIONAL_COLUMNS if getattr(recording, name) is not None]


def samples_csv(recording: Recording) -> str:
    """Return the content of `samples.csv`; floats are written so that they read back the same."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(columns_of(recording))
    for row in range(len(recording)):
        writer.writerow(row_of(recording, row))
    return out.getvalue()


def row_of(recording: Recording, row: int) -> list[str]:
    """Return one row of `samples.csv` as text."""
    values = [recording.time_s[row : row + 1], recording.q_cmd[row]]
    values += [pixels[row] for pixels in recording.markers_px.values()]
    if recording.q_meas is not None:
        values.append(recording.q_meas[row])
    for name in OPTIONAL_COLUMNS:
        column = getattr(recording, name)
        if column is not None:
            values.append(column[row : row + 1])
    cells = [_cell(value) for value in np.concatenate(values)]
    return [str(int(recording.sample[row])), cells[0], str(recording.trajectory[row]), *cells[1:]]


def _cell(value: float) -> str:
    return "" if math.isnan(value) else repr(float(value))
