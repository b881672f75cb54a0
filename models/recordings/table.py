"""The cells of `samples.csv`, read column by column; every breach of the contract is named by its row and column."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from armtwin.models.arm import Arm
from armtwin.models.csv_table import CsvTable, remedy
from armtwin.models.errors import RecordingError
from armtwin.models.validation import CameraTable, short

Array = NDArray[np.float64]

# Gross detection errors may lie outside the picture, but not by ten pictures.
_FAR_OUTSIDE = 10.0
# Nothing that is measured comes near it, not even the time of day in microseconds; its square is still a number.
_LARGEST = 1e18
_LONGEST_NAME = 200
# Whole numbers beyond are no degrees of a joint.
_MOST_DEGREES = 400.0


class Table:
    """The cells of `samples.csv`, converted column by column with the row and column in every message."""

    def __init__(self, cells: CsvTable) -> None:
        self._cells = cells
        self._rows = cells.rows

    def numbers(self, name: str, *, may_be_empty: bool = True) -> Array:
        """(N,) numbers, NaN where a cell is empty."""
        index = self._cells.columns.index(name)
        out = np.full(len(self._rows), np.nan)
        for row, cells in enumerate(self._rows):
            text = cells[index].strip()
            if not text:
                if not may_be_empty:
                    raise RecordingError(f"{self._at(row, name)}: empty, a number is wanted")
                continue
            try:
                out[row] = self._cells.number(row, name)
            except ValueError:
                raise RecordingError(f"{self._at(row, name)}: '{text[:40]}' is no number{remedy(text)}") from None
            if abs(out[row]) > _LARGEST and math.isfinite(out[row]):
                raise RecordingError(f"{self._at(row, name)}: '{text[:40]}' is beyond {_LARGEST:g}")
            if not math.isfinite(out[row]):
                raise RecordingError(
                    f"{self._at(row, name)}: '{text[:40]}' is not finite; "
                    + ("leave the cell empty where nothing was measured" if may_be_empty else "a number is wanted")
                )
        return out

    def names(self, name: str) -> NDArray[np.str_]:
        """(N,) names, each printable and of a reasonable length."""
        index = self._cells.columns.index(name)
        for row, cells in enumerate(self._rows):
            if not (cells[index] and cells[index].isprintable() and len(cells[index]) <= _LONGEST_NAME):
                raise RecordingError(
                    f"{self._at(row, name)}: found {short(cells[index])}, a name of 1 to {_LONGEST_NAME} printable "
                    "characters is wanted"
                )
        return np.array([cells[index] for cells in self._rows], dtype=np.str_)

    def within(self, name: str, low: float, high: float) -> Array:
        """(N,) numbers from `low` to `high`, NaN where a cell is empty."""
        values = self.numbers(name)
        beyond = np.flatnonzero((values < low) | (values > high))
        if len(beyond):
            row = int(beyond[0])
            raise RecordingError(
                f"{self._at(row, name)}: found {values[row]:g}, a number from {low:g} to {high:g} is wanted"
            )
        return values

    def angles(self, arm: Arm, kind: str, *, may_be_empty: bool) -> Array:
        """(N, n) angles of the joints, rad, commanded (`cmd`) or measured (`meas`)."""
        return self.joint_angles(arm.n_joints, kind, may_be_empty=may_be_empty)

    def joint_angles(self, n: int, kind: str, *, may_be_empty: bool) -> Array:
        """(N, n) angles of `n` joints, rad, commanded (`cmd`) or measured (`meas`)."""
        names = [f"theta{i + 1}_{kind}_rad" for i in range(n)]
        q = np.stack([self.numbers(name, may_be_empty=may_be_empty) for name in names], axis=-1)
        too_large = np.argwhere(np.abs(q) > 2 * np.pi)
        if len(too_large):
            row, joint = too_large[0]
            column = q[np.isfinite(q[:, joint]), joint]
            counts = np.abs(column).max() > _MOST_DEGREES and bool((column == np.round(column)).all())
            remedy = (
                "an encoder's counts: multiply by 2 pi over its counts a turn, from the middle of its range, or use "
                "`armtwin import csv --unit counts`"
                if counts
                else f"degrees: name the column {names[joint].removesuffix('_rad')}_deg, or multiply by pi/180"
            )
            raise RecordingError(
                f"{self._at(row, names[joint])}: {q[row, joint]:g} is beyond 2 pi; "
                f"angles are in radians, these look like {remedy}"
            )
        return q

    def pixels(self, name: str, camera: CameraTable | None) -> Array:
        """(N, 2) raw pixels of a marker, NaN where it was not seen."""
        u, v = (self.numbers(f"{name}_{axis}_px") for axis in "uv")
        half = np.isfinite(u) != np.isfinite(v)
        if half.any():
            row = int(np.argmax(half))
            raise RecordingError(
                f"{self._at(row, f'{name}_u_px')}: one of u and v is empty; give both, or neither for an unseen marker"
            )
        if camera is not None:
            size = max(camera.image_width, camera.image_height)
            far = np.maximum(np.abs(np.nan_to_num(u)), np.abs(np.nan_to_num(v))) > _FAR_OUTSIDE * size
            if far.any():
                row = int(np.argmax(far))
                raise RecordingError(
                    f"{self._at(row, f'{name}_u_px')}: ({u[row]:g}, {v[row]:g}) is far outside the "
                    f"{camera.image_width}x{camera.image_height} picture; pixels are wanted"
                )
        return np.stack([u, v], axis=-1)

    def samples(self) -> NDArray[np.int64]:
        """(N,) numbers of the samples, each once."""
        index = self._cells.columns.index("sample")
        out = np.empty(len(self._rows), dtype=np.int64)
        seen: dict[int, int] = {}
        for row, cells in enumerate(self._rows):
            text = cells[index].strip()
            if not text.isdecimal() or len(text) > 12:
                raise RecordingError(f"{self._at(row, 'sample')}: '{text[:40]}' is no whole number from 0")
            number = out[row] = int(text)
            if number in seen:
                raise RecordingError(
                    f"{self._at(row, 'sample')}: sample {number} stands already in line "
                    f"{self._cells.lines[seen[number]]}; "
                    "number every pose once"
                )
            seen[int(number)] = row
        return out

    def times(self) -> Array:
        """(N,) times, s, that never run backwards; NaN where a cell is empty."""
        return self._ordered("time_s")

    def growing_times(self) -> Array:
        """(N,) times, s, each later than the one before."""
        times = self.numbers("time_s", may_be_empty=False)
        still = np.flatnonzero(np.diff(times) <= 0)
        if len(still):
            row = int(still[0]) + 1
            how = "again" if times[row] == times[row - 1] else f"after {times[row - 1]:g} s"
            raise RecordingError(
                f"{self._at(row, 'time_s')}: {times[row]:g} s {how}; in a moving recording every row has a later time"
            )
        return times

    def command_times(self) -> Array:
        """(N,) times of the commands, s, that never run backwards, each before its row was seen; NaN where unknown."""
        given, seen = self._ordered("commanded_s"), self.numbers("time_s")
        early = np.flatnonzero(given > seen)
        if len(early):
            row = int(early[0])
            raise RecordingError(
                f"{self._at(row, 'commanded_s')}: {given[row]:g} s is after time_s, {seen[row]:g} s, when the row was "
                "seen; both are on one clock, and a command is given before what it does is seen"
            )
        lost = np.flatnonzero(np.isfinite(given) & ~np.isfinite(seen))
        if len(lost):
            row = int(lost[0])
            raise RecordingError(
                f"{self._at(row, 'commanded_s')}: {given[row]:g} s, and time_s is empty; say when the row was seen too"
            )
        return given

    def _ordered(self, name: str) -> Array:
        times = self.numbers(name)
        known = np.flatnonzero(np.isfinite(times))
        back = np.flatnonzero(np.diff(times[known]) < 0)
        if len(back):
            row = int(known[back[0] + 1])
            raise RecordingError(
                f"{self._at(row, name)}: time runs backwards, {times[row]:g} s after "
                f"{times[known[back[0]]]:g} s; rows stand in the order they happened"
            )
        return times

    def _at(self, row: int, name: str) -> str:
        return self._cells.at(row, name)
