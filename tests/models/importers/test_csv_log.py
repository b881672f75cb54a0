"""A person's own table: its columns proposed, or mapped by a file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from armtwin.models.errors import InputError
from armtwin.models.importers.csv_log import log_of, proposed_mapping, read_table
from armtwin.models.importers.mapping import mapping_text, read_mapping, unknown_units

TABLE = "t_ms;Shoulder target (deg);Shoulder actual (deg);elbowGoal_rad;elbowPos_rad;note\n"
ROWS = "0;10;9,5;0,1;0,11;a\n20;20;18,5;0,2;0,21;b\n40;30;29,5;0,3;;c\n"


def write(path: Path, text: str) -> Path:
    path.write_text(text)
    return path


def test_columns_are_paired_by_joint_and_read_in_their_units(tmp_path: Path) -> None:
    table = read_table(write(tmp_path / "run.csv", TABLE + ROWS))
    mapping = proposed_mapping(table)
    log = log_of(table, mapping)
    assert (log.joints, log.motion) == (("shoulder", "elbow"), "moving")
    np.testing.assert_allclose(log.time_s, [0.0, 0.02, 0.04])
    np.testing.assert_allclose(log.q_cmd, np.column_stack([np.radians([10, 20, 30]), [0.1, 0.2, 0.3]]))
    np.testing.assert_allclose(log.q_meas[:, 1], [0.11, 0.21, np.nan])
    assert list(log.trajectory) == ["run"] * 3
    assert log.notes == ("columns not used: note",)


def test_a_proposal_reads_back_and_can_be_mended(tmp_path: Path) -> None:
    table = read_table(write(tmp_path / "run.csv", TABLE + ROWS))
    text = mapping_text(proposed_mapping(table))
    assert log_of(table, read_mapping(write(tmp_path / "a.toml", text))).joints == ("shoulder", "elbow")
    actual = 'column = "Shoulder actual (deg)"\nunit = "deg"\n'
    turned = text.replace(actual + "sign = 1\noffset = 0.0\n", actual + "sign = -1\noffset = 90.0\n")
    log = log_of(table, read_mapping(write(tmp_path / "b.toml", turned)))
    np.testing.assert_allclose(log.q_meas[:, 0], -np.radians(np.array([9.5, 18.5, 29.5]) - 90.0))


def test_rows_a_second_apart_are_poses_at_rest(tmp_path: Path) -> None:
    text = "time_s,cmd_deg,meas_deg\n0,1,1\n1.5,2,2\n3,3,3\n"
    assert proposed_mapping(read_table(write(tmp_path / "run.csv", text))).motion == "settled"


def test_a_unit_that_no_name_tells_is_asked_for(tmp_path: Path) -> None:
    table = read_table(write(tmp_path / "run.csv", "time_s,goal,present_position\n0,100,101\n0.1,110,111\n"))
    mapping = proposed_mapping(table)
    assert unknown_units(mapping) == ["goal", "present_position"]
    text = mapping_text(mapping)
    with pytest.raises(InputError, match="the unit of column 'goal' is '\\?'; write rad, deg, counts"):
        read_mapping(write(tmp_path / "a.toml", text))
    counts = text.replace('unit = "?"', 'unit = "counts"\ncounts_per_turn = 4096')
    log = log_of(table, read_mapping(write(tmp_path / "b.toml", counts)))
    np.testing.assert_allclose(log.q_cmd[:, 0], 2 * np.pi * np.array([100, 110]) / 4096)


@pytest.mark.parametrize(
    ("cells", "unit"),
    [
        (["2048,2047", "3100,3090", "1500,1506"], "counts"),
        (["12.5,12.3", "40.0,39.5", "-100.25,-99"], "deg"),
        (["0.5,0.49", "1.5,1.48", "-2.25,-2.2"], "rad"),
        (["10,10", "20,19", "30,29"], "?"),  # whole: degrees, or counts of a small move
        (["0.01,0.01", "0.02,0.02", "0.03,0.03"], "?"),  # nothing that moves so little tells its unit
    ],
)
def test_values_that_can_be_of_one_unit_alone_tell_it(tmp_path: Path, cells: list[str], unit: str) -> None:
    rows = "\n".join(f"{20 * k},{cell}" for k, cell in enumerate(cells))
    mapping = proposed_mapping(read_table(write(tmp_path / "run.csv", f"t,elbow goal,elbow pos\n{rows}\n")))
    assert {mapping.joints[0].command.unit, mapping.joints[0].measured.unit} == {unit}
    assert mapping.time is not None
    assert (mapping.time.unit, mapping.motion) == ("ms", "moving")


def test_a_unit_that_is_said_holds_where_no_name_tells_another(tmp_path: Path) -> None:
    text = "time_s,elbow_goal,elbow_pos_deg\n0,2048,0.5\n0.02,2058,1\n0.04,2068,1.5\n"
    (joint,) = proposed_mapping(read_table(write(tmp_path / "run.csv", text)), "counts").joints
    assert (joint.command.unit, joint.command.counts_per_turn, joint.command.offset) == ("counts", 4096.0, 2048.0)
    assert joint.measured.unit == "deg"


@pytest.mark.parametrize(
    ("header", "said"),
    [
        ("time_s,voltage,speed", "no column of commands goes with one of readings"),
        ("time_s,elbow_target_deg,wrist_actual_deg", "no column of commands goes with one of readings"),
    ],
)
def test_columns_that_cannot_be_paired_are_listed(tmp_path: Path, header: str, said: str) -> None:
    with pytest.raises(InputError, match=said):
        proposed_mapping(read_table(write(tmp_path / "run.csv", f"{header}\n0,1,2\n1,1,2\n")))


def test_times_that_run_backwards_in_a_moving_log_are_named(tmp_path: Path) -> None:
    table = read_table(write(tmp_path / "run.csv", "time_s,cmd_deg,meas_deg\n0,1,1\n0.02,1,1\n0.01,1,1\n0.03,1,1\n"))
    with pytest.raises(InputError, match=r"row 3: 0.01 s after 0.02 s"):
        log_of(table, proposed_mapping(table))


def test_degrees_called_radians_are_noticed(tmp_path: Path) -> None:
    table = read_table(write(tmp_path / "run.csv", "time_s,cmd_rad,meas_rad\n0,1,1\n0.02,90,89\n"))
    with pytest.raises(InputError, match="more than a whole turn; is its unit another one"):
        log_of(table, proposed_mapping(table))
