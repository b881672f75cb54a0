"""What a diagnosis says of lengths, zeros and base, and of what it cannot know."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from armtwin.calib.arm.chain import Chain
from armtwin.calib.diagnosis.geometry import GeometryReport, geometry_report
from armtwin.calib.diagnosis.uncertainty import uncertainty
from armtwin.models.recordings.recording import Recording
from tests.support.diagnoses import data_of, geometry_of
from tests.support.recordings import BASE_MM, DEVIATION, recording


def report_of(seen: Recording) -> GeometryReport:
    data = data_of(seen)
    model = geometry_of(data)
    return geometry_report(data, model, uncertainty(data, model).covariance)


def test_lengths_and_zeros_come_out_as_the_arm_was_built_with_the_last_links_drawn_angle() -> None:
    seen = recording()
    report = report_of(seen)
    built = Chain(seen.arm).in_convention(DEVIATION)
    np.testing.assert_allclose(report.deviation.lengths_mm, built.lengths_mm, atol=0.05)
    np.testing.assert_allclose(report.deviation.joints_rad, built.joints_rad, atol=5e-4)
    np.testing.assert_allclose(report.base_in_board_mm, BASE_MM, atol=0.05)


def test_six_parameters_are_known_and_the_seventh_is_named_as_a_gauge() -> None:
    report = report_of(recording())
    assert report.identifiable == 6
    assert any("theta3's zero against a rotation of (l4, l5)" in words for words in report.gauge)
    assert any(words.startswith("plane_offset: ") for words in report.gauge)


def test_the_tip_alone_with_one_joint_moving_leaves_directions_that_are_told_as_not_known() -> None:
    still = {"wave": np.array([0.2, -0.1, 0.3]) + np.zeros((40, 3))}
    still["wave"][:, 0] += np.linspace(-0.3, 0.3, 40)
    report = report_of(recording(paths=still, markers="f"))
    assert report.identifiable < 6
    assert any("are not told by these poses and markers" in words for words in report.gauge)


def test_measured_angles_show_zeros_and_no_lengths() -> None:
    seen = recording()
    angles = replace(
        seen, markers_px={}, camera=None, q_meas=seen.q_cmd + np.array([0.01, -0.02, 0.03]), pixel_noise_px=1e-3
    )
    report = report_of(angles)
    np.testing.assert_allclose(report.values, [0.01, -0.02, 0.03], atol=1e-9)
    assert report.gauge == ("link lengths: joint angles alone do not show them",)
