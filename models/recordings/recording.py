"""Recordings (`armtwin.recording/1`): measured data, a folder of `recording.json`, `samples.csv`, maybe `frames/`."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from armtwin.models.arm import Arm
from armtwin.models.camera import Camera
from armtwin.models.tabular import html_table

Array = NDArray[np.float64]

SCHEMA = "armtwin.recording/1"
OPTIONAL_COLUMNS = ("commanded_s", "payload_kg", "temperature_c")


@dataclass(frozen=True, eq=False)
class Recording:
    """What was commanded and what was seen, one row a pose, in the order they happened.

    Attributes:
        arm, camera: the nominal arm and the calibrated camera; `camera` is None where only angles were measured.
        arm_plane_z_mm: the arm's plane in the board frame, mm; None without a camera.
        sample: (N,) numbers of the poses; frames are named by them.
        time_s: (N,) when each row was seen, s; NaN where time was not recorded.
        commanded_s: (N,) when its command was given, on the same clock, NaN where that is not known, or None.
        trajectory: (N,) names.
        q_cmd: (N, n) commanded joint angles, rad.
        markers_px: raw pixels (N, 2) of each marker by name; NaN where it was not seen.
        q_meas: (N, n) measured joint angles, rad, NaN where missing, or None.
        payload_kg, temperature_c: (N,) or None.
        pixel_noise_px: standard deviation of one pixel coordinate, or None where it is not known.
        held_out: trajectories to be kept for validation; empty where the file names none.
        folder: where it was read from, None for one made in memory.

    """

    arm: Arm
    sample: NDArray[np.int64]
    time_s: Array
    trajectory: NDArray[np.str_]
    q_cmd: Array
    markers_px: dict[str, Array] = field(default_factory=dict)
    q_meas: Array | None = None
    commanded_s: Array | None = None
    payload_kg: Array | None = None
    temperature_c: Array | None = None
    camera: Camera | None = None
    arm_plane_z_mm: float | None = None
    pixel_noise_px: float | None = None
    held_out: tuple[str, ...] = ()
    folder: Path | None = None

    def __len__(self) -> int:
        return len(self.sample)

    @property
    def has_time(self) -> bool:
        """Whether every row has a time."""
        return bool(np.isfinite(self.time_s).all())

    def columns(self) -> dict[str, NDArray[Any]]:
        """Return the columns of `samples.csv` by name, (N,) each, NaN where a cell is empty."""
        n = range(self.arm.n_joints)
        out: dict[str, NDArray[Any]] = {"sample": self.sample, "time_s": self.time_s, "trajectory": self.trajectory}
        out |= {f"theta{i + 1}_cmd_rad": self.q_cmd[:, i] for i in n}
        for name, pixels in self.markers_px.items():
            out |= {f"{name}_{axis}_px": pixels[:, k] for k, axis in enumerate("uv")}
        if self.q_meas is not None:
            out |= {f"theta{i + 1}_meas_rad": self.q_meas[:, i] for i in n}
        return out | {name: getattr(self, name) for name in OPTIONAL_COLUMNS if getattr(self, name) is not None}

    def _repr_html_(self) -> str:
        kinds = len(set(self.trajectory.tolist()))
        return html_table(f"Recording of '{self.arm.name}': {len(self)} rows, {kinds} trajectories", self.columns())

    def frame_path(self, row: int) -> Path | None:
        """Return where the frame of a row would be, or None for a recording made in memory."""
        return None if self.folder is None else self.folder / "frames" / f"{self.sample[row]:06d}.png"


def make_samples(n: int) -> NDArray[np.int64]:
    """(n,) sample numbers from 0."""
    return np.arange(n, dtype=np.int64)
