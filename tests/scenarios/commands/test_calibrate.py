import json
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from armtwin.models.arm import nominal_arm, read_arm
from armtwin.models.camera import project
from armtwin.models.camera_files import read_camera
from armtwin.models.coordinate_frames import robot_to_board
from armtwin.models.errors import InputError
from armtwin.models.kinematics import Deviation, forward, inverse, marker_positions
from armtwin.models.recordings.recording import Recording
from armtwin.models.recordings.writer import write_recording
from armtwin.models.trajectories import paper_trajectories
from armtwin.scenarios.commands.calibrate import Method, calibrate_command

BASE_MM = np.array([-35.0, -20.0, -80.87])
TRUTH = Deviation(np.array([6.7015, 4.5704, -0.7074, 1.0208]), np.radians([1.1354, 1.0037, 4.7563]))
WEBCAM = Path(__file__).resolve().parents[3] / "models" / "nominal" / "webcam.yaml"


@pytest.fixture
def recording() -> Recording:
    """The paper's three trajectories by an arm that deviates as Table 4 says, the line held out."""
    arm, camera = nominal_arm(), read_camera(WEBCAM)
    poses = paper_trajectories()
    q = inverse(arm, np.concatenate(list(poses.values())))
    points = marker_positions(arm, q, TRUTH)
    rng = np.random.default_rng(0)
    return Recording(
        arm=arm,
        camera=camera,
        arm_plane_z_mm=-80.87,
        held_out=("line",),
        sample=np.arange(150),
        time_s=np.full(150, np.nan),
        trajectory=np.repeat(list(poses), 50),
        q_cmd=q,
        markers_px={
            name: project(camera, robot_to_board(points[:, i], BASE_MM)) + rng.normal(0, 0.06, (150, 2))
            for i, name in enumerate(arm.marker_names)
        },
    )


def calibrated(tmp_path: Path, recording: Recording, **options) -> dict:
    """Run the command on the recording and read what it wrote."""
    write_recording(tmp_path / "recording", recording)
    calibrate_command(tmp_path / "recording", tmp_path / "out", **options)
    return json.loads((tmp_path / "out" / "calibration.json").read_text())


def refused(tmp_path: Path, recording: Recording, message: str, **options) -> None:
    """The command is refused in one line, and writes nothing."""
    with pytest.raises(InputError, match=message) as error:
        calibrated(tmp_path, recording, **options)
    assert "\n" not in str(error.value)
    assert not (tmp_path / "out").exists()


def test_it_writes_estimates_with_deviations_and_intervals_around_the_truth(tmp_path, recording):
    table = calibrated(tmp_path, recording)
    assert table["schema"] == "armtwin.calibration/1"
    l1 = table["parameters"]["delta_l1_mm"]
    assert l1["value"] == pytest.approx(6.7015, abs=5 * l1["std"])
    assert l1["interval95"][0] < l1["value"] < l1["interval95"][1]
    assert table["identifiable"] == 6
    assert len(table["gauge"]) == 1
    assert table["base_in_board_mm"] == pytest.approx(BASE_MM.tolist(), abs=0.02)


def test_it_compares_the_tips_error_before_and_after_on_the_held_out_line(tmp_path, recording):
    fitted, line = calibrated(tmp_path, recording)["errors"]
    assert (fitted["name"], fitted["held_out"]) == ("fitted", False)
    assert (line["name"], line["held_out"]) == ("line", True)
    assert line["before"]["n"] == 50
    arm, poses = nominal_arm(), paper_trajectories()["line"]
    drawn_error = np.linalg.norm((forward(arm, inverse(arm, poses), TRUTH) - poses)[:, :2], axis=1).mean()
    assert line["before"]["mean_mm"] == pytest.approx(drawn_error, abs=0.02)
    assert line["after"]["mean_mm"] < 0.05


def test_the_arm_file_holds_the_calibrated_lengths_and_can_be_read(tmp_path, recording):
    table = calibrated(tmp_path, recording)
    arm = read_arm(tmp_path / "out" / "arm.toml")
    assert arm.name == "planar3"
    np.testing.assert_allclose(arm.link_lengths_mm[:2], [126.7015, 126.2704], atol=0.05)
    np.testing.assert_allclose(arm.link_lengths_mm, nominal_arm().link_lengths_mm + table["lengths_mm"])


def test_algorithm_1_ends_near_table_4_from_the_papers_start(tmp_path, recording):
    table = calibrated(tmp_path, recording, method=Method.ALGORITHM_1)
    assert table["method"] == "algorithm-1"
    assert table["parameters"]["delta_l1_mm"]["std"] is None
    assert table["errors"][1]["after"]["mean_mm"] < table["errors"][1]["before"]["mean_mm"]


def test_trajectories_named_on_the_command_line_are_held_out_instead(tmp_path, recording):
    table = calibrated(tmp_path, recording, hold_out=["circle_15", "line"])
    assert [row["name"] for row in table["errors"]] == ["fitted", "circle_15", "line"]
    assert table["n_poses"] == 50


def test_a_held_out_trajectory_without_the_tip_has_no_error(tmp_path, recording):
    recording.markers_px["f"][100:] = np.nan
    assert calibrated(tmp_path, recording)["errors"][1]["before"] is None


def test_joint_angles_alone_are_calibrated(tmp_path, recording):
    angles = replace(recording, camera=None, arm_plane_z_mm=None, markers_px={}, q_meas=recording.q_cmd + 0.02)
    table = calibrated(tmp_path, angles)
    assert table["method"] == "joint-angles"
    assert table["joints_rad"] == pytest.approx([0.02] * 3)
    assert table["errors"][1]["joint_rms_before_rad"] == pytest.approx(0.02)
    assert table["errors"][1]["joint_rms_after_rad"] == pytest.approx(0.0, abs=1e-9)


def test_the_same_recording_gives_the_same_bytes(tmp_path, recording):
    calibrated(tmp_path, recording)
    first = (tmp_path / "out" / "calibration.json").read_bytes()
    calibrated(tmp_path, recording)
    assert (tmp_path / "out" / "calibration.json").read_bytes() == first


def test_what_else_is_in_the_output_folder_stays(tmp_path, recording):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "notes.txt").write_text("mine")
    calibrated(tmp_path, recording)
    assert sorted(p.name for p in (tmp_path / "out").iterdir()) == ["arm.toml", "calibration.json", "notes.txt"]


def test_it_prints_a_table_in_degrees_with_intervals_and_errors(tmp_path, recording, capsys):
    calibrated(tmp_path, recording)
    said = capsys.readouterr().out
    assert "delta_theta1_deg" in said
    assert "6 of 7 link parameters can be known" in said
    assert "line (held out)" in said


def test_it_warns_when_the_residuals_are_larger_than_the_stated_noise(tmp_path, recording, capsys):
    play = np.random.default_rng(1).normal(0, 5e-3, (150, 1)) * np.array([0.0, 1.0, 0.0])
    shaken = marker_positions(recording.arm, recording.q_cmd + play, TRUTH)
    for i, name in enumerate("abcf"):
        recording.markers_px[name][:] = project(recording.camera, robot_to_board(shaken[:, i], BASE_MM))
    calibrated(tmp_path, replace(recording, pixel_noise_px=0.06))
    said = " ".join(capsys.readouterr().out.split())
    assert "the recording states 0.06 px: something moves that the geometry does not explain" in said


def test_it_does_not_warn_of_pure_noise(tmp_path, recording, capsys):
    calibrated(tmp_path, replace(recording, pixel_noise_px=0.06))
    assert "something moves" not in capsys.readouterr().out


def test_the_arm_file_is_plain_toml_with_its_schema(tmp_path, recording):
    calibrated(tmp_path, recording)
    table = tomllib.loads((tmp_path / "out" / "arm.toml").read_text())
    assert table["schema"] == "armtwin.arm/1"
    assert len(table["link_lengths_mm"]) == 4


def test_all_markers_hidden_is_refused(tmp_path, recording):
    for pixels in recording.markers_px.values():
        pixels[:] = np.nan
    refused(tmp_path, recording, "no marker is seen in any of the 100 poses")


def test_too_few_poses_are_refused(tmp_path, recording):
    for pixels in recording.markers_px.values():
        pixels[3:] = np.nan
    refused(tmp_path, recording, "3 poses with a measurement .* measure 2 more")


def test_collinear_poses_are_refused(tmp_path, recording):
    q = np.linspace(0, 0.4, 150)[:, None] * np.array([1.0, 0.0, 0.0])
    tip = marker_positions(recording.arm, q, TRUTH)[:, -1]
    only_f = {"f": project(recording.camera, robot_to_board(tip, BASE_MM))}
    refused(tmp_path, replace(recording, q_cmd=q, markers_px=only_f), "poses are collinear")


def test_an_unknown_trajectory_to_hold_out_is_refused(tmp_path, recording):
    refused(
        tmp_path, recording, "--hold-out: samples.csv has no trajectory 'lime'; did you mean 'line'", hold_out=["lime"]
    )


def test_a_file_in_place_of_the_output_folder_is_refused(tmp_path, recording):
    (tmp_path / "out").write_text("mine")
    with pytest.raises(InputError, match="is a file, --out wants a folder"):
        calibrated(tmp_path, recording)
    assert (tmp_path / "out").read_text() == "mine"


def test_lengths_that_no_arm_has_are_refused(tmp_path, recording):
    """A sticker for E on the wrong side of the tip, say: l5 would come out negative."""
    bent = Deviation(np.array([0.0, 0.0, 0.0, -20.0]), np.zeros(3))
    points = marker_positions(recording.arm, recording.q_cmd, bent)
    c, f = (points[:, i, 0] + 1j * points[:, i, 1] for i in (2, 3))
    e = c + (f - c) * 38.0 / (38.0 - 1j * (6.73 - 20.0))
    seen = {
        "a": points[:, 0],
        "b": points[:, 1],
        "c": points[:, 2],
        "e": np.stack([e.real, e.imag], -1),
        "f": points[:, 3],
    }
    markers = {name: project(recording.camera, robot_to_board(xy, BASE_MM)) for name, xy in seen.items()}
    refused(
        tmp_path, replace(recording, markers_px=markers), r"calibrated arm: link_lengths_mm entry 4: .*found -13\.2"
    )
