"""Make the worlds of a sealed set and keep the truth apart from their recordings."""

from __future__ import annotations

import contextlib
import json
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from pydantic import BaseModel

from armtwin.calib.markers import measure_recording
from armtwin.models import atomic
from armtwin.models.errors import InputError, JobError
from armtwin.models.folder_lock import only_writer
from armtwin.models.recordings.recording import Recording
from armtwin.models.recordings.writer import write_recording
from armtwin.models.validation import Finite, Positive, check
from armtwin.models.world import World
from armtwin.scenarios.scoring.moving_orders import moving_orders
from armtwin.scenarios.scoring.moving_sealing import LogTruth, make_log
from armtwin.scenarios.scoring.orders import Kind, Order, SealOptions, load_uncatalogued, orders
from armtwin.scenarios.scoring.pool import in_processes
from armtwin.sim.bench import SimulatedBench
from armtwin.sim.sealed import STRENGTHS, Sealed, draw_world

SCHEMA = "armtwin.sealed/1"
_MOST_DIGITS = 9


@dataclass(frozen=True)
class Task:
    """World `index` of a set in folder `out`."""

    out: Path
    options: SealOptions
    index: int
    order: Order


class _HiddenTruth(BaseModel):
    """What the score reads of a hidden effect."""

    effect: str
    joint: int | None
    marker: str | None
    parameters: dict[str, Any]
    moved_noises: Finite


class _WorldTruth(BaseModel):
    """What the score reads of a world; further keys are for people."""

    kind: Kind
    effects: list[_HiddenTruth]
    n_poses: int
    noise_px: Positive
    link_lengths_mm: list[Finite]
    joint_offsets_rad: list[Finite]
    base_in_board_mm: tuple[Finite, Finite, Finite]


def world_folder(out: Path, index: int) -> Path:
    """Return where a world's recording is."""
    return out / "worlds" / f"{index:04d}"


def seal(out: Path, options: SealOptions, jobs: int) -> Iterator[int]:
    """Make the worlds that `out` does not hold yet; yields each one's index when it is done.

    Raises `InputError` where `out` holds another set, or another process is at work there.
    """
    wanted = moving_orders(options) if options.moving else orders(options)
    out.mkdir(parents=True, exist_ok=True)
    with only_writer(out):
        made = _begin(out, options)
        tasks = [(k, Task(out, options, k, order)) for k, order in enumerate(wanted) if f"{k:04d}" not in made]
        for index, truth in in_processes(make_world, tasks, jobs):
            if isinstance(truth, BaseException):
                raise truth
            made[f"{index:04d}"] = truth
            _write_truth(out, options, made)
            yield index


def make_world(task: Task) -> dict[str, Any]:
    """Make one world, write its recording and return the truth about it."""
    rng = np.random.default_rng(np.random.SeedSequence(task.options.seed, spawn_key=(1, task.index)))
    if task.options.moving:
        return make_log(world_folder(task.out, task.index), task.order, rng)
    sealed = _drawn(task, rng)
    truth = {"kind": task.order.kind, **sealed.truth}
    with atomic.folder_aside(world_folder(task.out, task.index)) as folder:
        recording = sealed.recording
        if task.options.frames:
            recording = filmed(folder, recording, sealed.world, rng)
            truth |= _by_measured_noise(truth, recording)
        write_recording(folder, recording)
    return truth


def _drawn(task: Task, rng: np.random.Generator) -> Sealed:
    """Draw a world at its strength, or at the next weaker one that its effects can reach."""
    order = task.order
    levels = list(STRENGTHS)
    for strength in levels[levels.index(order.strength) :: -1]:
        with contextlib.suppress(JobError):
            if order.kind != "uncatalogued":
                return draw_world(rng, order.effects or None, strength)
            assert task.options.uncatalogued is not None
            return load_uncatalogued(Path(task.options.uncatalogued)).draw(rng, order.effects[0], strength)
    raise JobError(f"world {task.index}: no draw in which {' and '.join(order.effects)} shows above the noise")


def filmed(folder: Path, recording: Recording, world: World, rng: np.random.Generator) -> Recording:
    """Render every pose into `folder/frames` and return the recording with what was measured in them."""
    timed = recording.has_time and len(recording) > 1
    period = float(np.median(np.diff(recording.time_s))) if timed else world.pose_period_s
    lag, n = world.picture_lag, len(recording)
    bench = SimulatedBench(replace(world, picture_lag=0, pose_period_s=period), seed=rng, n_poses=n)
    (folder / "frames").mkdir()
    filed: dict[int, list[int]] = {}
    for row, pose in enumerate(np.clip(np.arange(n) - lag, 0, n - 1)):
        filed.setdefault(int(pose), []).append(row)
    bench.connect()
    try:
        for pose in range(n):
            if recording.payload_kg is not None:
                bench.hang(float(recording.payload_kg[pose]))
            bench.move(recording.q_cmd[pose])
            if pose in filed:
                png = cv2.imencode(".png", bench.capture().image)[1].tobytes()
                for row in filed[pose]:
                    atomic.write_bytes(folder / "frames" / f"{recording.sample[row]:06d}.png", png)
    finally:
        bench.close()
    measured = measure_recording(replace(recording, folder=folder))
    markers = {name: pixels for name, pixels in measured.markers_px.items() if name in recording.markers_px}
    for detection in world.detections:  # what goes wrong after the picture was taken
        markers = detection(markers, rng)
    return replace(measured, markers_px=markers)


def _by_measured_noise(truth: dict[str, Any], recording: Recording) -> dict[str, Any]:
    """Return the noise of the pictures, in place of that which bare pixels were to have, and displacements over it."""
    noise = recording.pixel_noise_px
    if noise is None:
        return {}
    effects = [{**effect, "moved_noises": effect["moved_px"] / noise} for effect in truth["effects"]]
    return {"noise_px": noise, "effects": effects}


def _begin(out: Path, options: SealOptions) -> dict[str, Any]:
    """Return the truth of the worlds that are there already."""
    if not (out / "truth.json").is_file():
        if out.exists() and (not out.is_dir() or set(out.iterdir()) - set(atomic.leftovers(out))):
            raise InputError(f"{out}: holds no sealed worlds and is not empty; choose another --out")
        _write_truth(out, options, {})  # so that a set killed in its first world is known for one
    table = _read_table(out)
    if check(SealOptions, table.get("options"), f"{out / 'truth.json'}: options") != options:
        raise InputError(f"{out}: holds worlds that were sealed with other options; choose another --out")
    atomic.clear_leftovers(out)
    worlds: dict[str, Any] = table["worlds"]
    return worlds


def _write_truth(out: Path, options: SealOptions, worlds: dict[str, Any]) -> None:
    table = {"schema": SCHEMA, "options": options.model_dump(mode="json"), "worlds": dict(sorted(worlds.items()))}
    atomic.write_json(out / "truth.json", table)


def read_truth(out: Path) -> dict[str, Any]:
    """Read a set's truth; raises `InputError`, and `JobError` where no world was finished."""
    table = _read_table(out)
    if not table["worlds"]:
        raise JobError(f"{out / 'truth.json'}: no world was finished; run armtwin seal again with the same options")
    return table


def is_moving(out: Path) -> bool:
    """Whether a set holds logs of moving arms; raises `InputError`."""
    options = _read_table(out).get("options")
    return isinstance(options, dict) and options.get("moving") is True


def _read_table(out: Path) -> dict[str, Any]:
    path = out / "truth.json"
    if not path.is_file():
        raise InputError(f"{out}: holds no truth.json; make sealed worlds with armtwin seal --out {out}")
    try:
        table: dict[str, Any] = json.loads(path.read_text("utf-8"))
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: not JSON ({error})") from None
    if not isinstance(table, dict) or table.get("schema") != SCHEMA or not isinstance(table.get("worlds"), dict):
        raise InputError(f"{path}: key 'schema' is wanted as {SCHEMA}, with 'options' and 'worlds'")
    options = table.get("options")
    moving = isinstance(options, dict) and options.get("moving") is True
    for name, world in table["worlds"].items():  # the names are those of folders
        if not (name.isascii() and name.isdecimal() and len(name) <= _MOST_DIGITS):
            raise InputError(f"{path}: worlds: found {name[:40]!r}, a number such as 0007 is wanted")
        check(LogTruth if moving else _WorldTruth, world, f"{path}: worlds.{name}")
    return table
