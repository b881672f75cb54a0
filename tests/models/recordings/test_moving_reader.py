"""A recording of a moving arm is read as the contract says; every breach of it is one line with the remedy."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from armtwin.models.errors import RecordingError
from armtwin.models.motion.loads import gravity_torques
from armtwin.models.recordings.moving_reader import is_moving, read_moving

_INERTIA = '<inertial pos="0.1 0 0" mass="{}" diaginertia="1e-4 1e-4 1e-4"/>'
MODEL = f"""<mujoco><worldbody><body><joint name="pan" axis="0 0 1"/>{_INERTIA.format(0.2)}
<body pos="0.2 0 0"><joint name="lift" axis="0 1 0"/>{_INERTIA.format(0.1)}<geom type="mesh" mesh="gone"/></body>
</body></worldbody><asset><mesh name="gone" file="elsewhere/gone.stl"/></asset></mujoco>"""
Header = dict[str, Any]
Rows = list[list[str]]


def written(
    folder: Path,
    header: Callable[[Header], object] = lambda h: None,
    rows: Callable[[Rows], object] = lambda r: None,
) -> Path:
    """Write a log of two motions of a model's two joints, spoilt by the functions."""
    folder.mkdir()
    (folder / "arm.xml").write_text(MODEL, "utf-8")
    top: Header = {
        "schema": "armtwin.recording/1",
        "motion": "moving",
        "arm": {"name": "two", "model": "arm.xml", "joints": ["pan", "lift"]},
        "held_out": ["two"],
    }
    header(top)
    (folder / "recording.json").write_text(json.dumps(top), "utf-8")
    columns = [f"theta{joint}_{kind}_rad" for kind in ("cmd", "meas") for joint in (1, 2)]
    table = [["sample", "time_s", "trajectory", *columns]]
    for k in range(80):
        angles = (f"{v:.4f}" for v in (0.01 * k, 0.1, 0.0099 * k, 0.1))
        table.append([str(k), f"{0.02 * k:.3f}", "one" if k < 40 else "two", *angles])
    rows(table)
    with (folder / "samples.csv").open("w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows(table)
    return folder


def test_motions_begin_where_the_trajectory_changes(tmp_path: Path) -> None:
    recording = read_moving(written(tmp_path / "log"))
    assert recording.motions == ("one", "two")
    assert np.flatnonzero(recording.first).tolist() == [0, 40]
    assert recording.joint_names == ("pan", "lift")
    assert is_moving(tmp_path / "log")


def test_a_models_meshes_are_not_needed_for_its_loads(tmp_path: Path) -> None:
    recording = read_moving(written(tmp_path / "log"))
    loads = gravity_torques(recording.arm, np.zeros((1, 2)))
    assert loads is not None
    # 0.1 kg at 0.1 m about a level axis, against gravity in -z
    np.testing.assert_allclose(np.abs(loads), [[0.0, 0.1 * 0.1 * 9.81]], atol=1e-12)


def set_arm(key: str, value: object) -> Callable[[Header], object]:
    return lambda header: header["arm"].update({key: value})


def cell(row: int, column: int, text: str) -> Callable[[Rows], object]:
    return lambda rows: rows[row].__setitem__(column, text)


WRONG: dict[str, tuple[Callable[[Header], object], Callable[[Rows], object], str]] = {
    "a model that lies outside": (set_arm("model", "../arm.xml"), lambda r: None, "outside the recording"),
    "a model by an absolute path": (set_arm("model", "/etc/hostname.xml"), lambda r: None, "outside the recording"),
    "a model that is not there": (set_arm("model", "arm.urdf"), lambda r: None, "there is no file 'arm.urdf'"),
    "a joint that stands twice": (set_arm("joints", ["pan", "pan"]), lambda r: None, "stands twice"),
    "a register for each joint": (lambda h: h.update(servo={"p_gain": [16]}), lambda r: None, "one for each of 2"),
    "an unknown key": (lambda h: h.update(clok="measured"), lambda r: None, "clock"),
    "a held-out motion that is not there": (lambda h: h.update(held_out=["tow"]), lambda r: None, "did you mean 'two'"),
    "all motions held out": (lambda h: h.update(held_out=["one", "two"]), lambda r: None, "leave one to fit"),
    "a time that comes twice": (lambda h: None, cell(5, 1, "0.060"), "line 6, column 'time_s': 0.06 s again"),
    "a time that runs backwards": (lambda h: None, cell(5, 1, "0.01"), "after 0.06 s"),
    "a missing time": (lambda h: None, cell(5, 1, ""), "line 6, column 'time_s': empty"),
    "no column of times": (lambda h: None, lambda rows: [row.pop(1) for row in rows], "needs the time of every row"),
    "degrees": (lambda h: None, cell(9, 5, "45.0"), "look like degrees"),
    "milliseconds": (
        lambda h: None,
        lambda rows: [row.__setitem__(1, str(25.0 * k)) for k, row in enumerate(rows[1:])],
        "time_ms",
    ),
    "microseconds": (
        lambda h: None,
        lambda rows: [row.__setitem__(1, str(20_000.0 * k)) for k, row in enumerate(rows[1:])],
        "time_us",
    ),
    "times in another unit than seconds": (
        lambda h: None,
        lambda rows: [row.__setitem__(1, str(1e-5 * k)) for k, row in enumerate(rows[1:])],
        "more often than any arm is read",
    ),
    "counts": (
        lambda h: None,
        lambda rows: [row.__setitem__(5, str(2048 + k)) for k, row in enumerate(rows[1:])],
        "an encoder's counts: multiply by 2 pi",
    ),
    "rows that are all motions of their own": (
        lambda h: h.pop("held_out"),
        lambda rows: [row.__setitem__(2, f"m{k}") for k, row in enumerate(rows[1:])],
        "every row is a trajectory of its own",
    ),
    "readings that are the commands again": (
        lambda h: None,
        lambda rows: [row.__setitem__(5, row[3]) for row in rows[1:]],
        "the goal was logged again",
    ),
    "readings that are stuck": (
        lambda h: None,
        lambda rows: [(row.__setitem__(5, "0.3"), row.__setitem__(6, "0.1")) for row in rows[1:]],
        "readings that are stuck",
    ),
    "commands that never change": (
        lambda h: None,
        lambda rows: [(row.__setitem__(3, "0"), row.__setitem__(4, "0")) for row in rows[1:]],
        "no command ever changes",
    ),
    "a motion that begins twice": (lambda h: None, cell(60, 2, "one"), "begins twice"),
}


@pytest.mark.parametrize("wrong", WRONG)
def test_what_is_wrong_is_told_in_one_line(tmp_path: Path, wrong: str) -> None:
    header, rows, said = WRONG[wrong]
    with pytest.raises(RecordingError) as error:
        read_moving(written(tmp_path / "log", header, rows))
    assert said in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("model", "said"),
    [
        ("<mujoco", "no XML"),
        ("<html/>", "begins with <html>"),
        ('<mujoco><include file="/etc/passwd"/></mujoco>', "includes another file"),
        ("<mujoco><worldbody><body><joint name='pan'/></body></worldbody></mujoco>", "does not load"),
        (MODEL.replace('name="lift"', 'name="elbow"'), "no joint 'lift'"),
    ],
)
def test_a_model_that_cannot_be_used_is_named_with_the_reason(tmp_path: Path, model: str, said: str) -> None:
    folder = written(tmp_path / "log")
    (folder / "arm.xml").write_text(model, "utf-8")
    recording = read_moving(folder)
    with pytest.raises(RecordingError) as error:
        gravity_torques(recording.arm, recording.q_meas)
    assert said in str(error.value)
