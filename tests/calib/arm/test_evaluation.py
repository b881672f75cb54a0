from dataclasses import replace

import numpy as np
import pytest

from armtwin.calib.arm.evaluation import drawn_base_mm, joint_error_rms, tip_distances, tip_error
from armtwin.calib.diagnosis.problem import problem_of
from armtwin.models.errors import InputError
from armtwin.models.kinematics import forward
from tests.support.recordings import recording

BASE = np.array([-35.0, -20.0, -80.87])


def test_the_tips_error_of_the_drawing_is_its_distance_from_the_built_arm(simulate, table_4_deviation):
    recording = simulate(delta=table_4_deviation)
    line = np.flatnonzero(recording.trajectory == "line")
    found = tip_error(recording, line, BASE)
    q = recording.q_cmd[line]
    built, drawn = (forward(recording.arm, q, delta)[:, :2] for delta in (table_4_deviation, None))
    distance = np.linalg.norm(built - drawn, axis=1)
    assert found.n == 50
    assert found.mean_mm == pytest.approx(distance.mean(), abs=1e-9)
    assert found.rms_mm == pytest.approx(np.sqrt((distance**2).mean()), abs=1e-9)
    assert found.max_mm == pytest.approx(distance.max(), abs=1e-9)


def test_with_the_true_deviation_nothing_is_left(simulate, table_4_deviation):
    recording = simulate(delta=table_4_deviation)
    assert tip_error(recording, np.arange(150), BASE, table_4_deviation).max_mm < 1e-9


def test_poses_without_the_tip_are_not_counted(simulate):
    recording = simulate()
    recording.markers_px["f"][:20] = np.nan
    assert tip_error(recording, np.arange(50), BASE).n == 30
    assert np.isnan(tip_distances(recording, np.arange(50), BASE)[:20]).all()


def test_a_tip_never_seen_is_refused(simulate):
    with pytest.raises(InputError, match="marker f is not seen in any pose"):
        tip_error(simulate(markers="abc"), np.arange(150), BASE)


def test_without_measured_angles_there_is_no_joint_error(simulate):
    assert np.isnan(joint_error_rms(simulate(), np.arange(10)))


def test_the_drawings_arm_stands_where_the_diagnosis_puts_it() -> None:
    """What is measured "by the drawing" is one thing in both commands."""
    for without_base in (False, True):
        made = recording()
        if without_base:
            made = replace(made, markers_px={name: px for name, px in made.markers_px.items() if name != "a"})
        np.testing.assert_allclose(drawn_base_mm(made), problem_of(made).base_in_board_mm, atol=1e-9)
