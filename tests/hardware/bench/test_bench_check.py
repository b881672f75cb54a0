"""What is made of the turns that the picture shows; the whole check runs in tests/scenarios/commands."""

import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import armtwin.hardware
from armtwin.hardware.bench.bench_check import judge_joint, judge_zeros
from armtwin.hardware.bench.bench_file import BenchSetup, read_bench


def test_a_joint_that_does_as_told_is_good(setup: BenchSetup):
    assert judge_joint(setup, 1, np.array([0.01, 0.97, 0.0])).good


def test_wrong_sign_names_the_direction_to_set(setup: BenchSetup):
    finding = judge_joint(setup, 1, np.array([0.0, -1.0, 0.0]))

    assert not finding.good
    assert finding.text == "joint 2 turns the wrong way: set its direction = 1"  # the file says -1


def test_wrong_order_names_the_joint_that_turned(setup: BenchSetup):
    finding = judge_joint(setup, 0, np.array([0.0, 0.0, 1.0]))

    assert not finding.good
    assert "joint 1 turns joint 3 instead" in finding.text


def test_a_joint_that_stands_is_named(setup: BenchSetup):
    finding = judge_joint(setup, 2, np.array([0.02, 0.0, 0.1]))

    assert not finding.good
    assert "joint 3 does not move" in finding.text


def test_wrong_scale_names_the_slope_to_set(setup: BenchSetup):
    finding = judge_joint(setup, 2, np.array([0.0, 0.0, 1.5]))

    assert not finding.good
    assert "joint 3 turns 1.50 times what is commanded: set its us_per_rad = 400" in finding.text  # 600 / 1.5


def test_a_joint_that_drags_another_is_named(setup: BenchSetup):
    assert not judge_joint(setup, 0, np.array([1.0, 0.4, 0.0])).good


def test_a_horn_on_the_wrong_tooth_names_the_zero_to_set(setup: BenchSetup):
    (finding,) = judge_zeros(setup, np.array([0.0, 0.25, 0.0]))

    assert not finding.good
    assert "joint 2 stands +14 deg" in finding.text
    slope = setup.servo_map.us_per_rad[1]
    assert abs(1659 + slope * 0.25 - 1500) < 1  # with it, the pulse that was sent stands for the angle that was seen


def test_small_zero_offsets_are_left_to_the_calibration(setup: BenchSetup):
    (finding,) = judge_zeros(setup, np.radians([1.1, 1.0, 4.8]))

    assert finding.good


def test_the_guide_shows_what_is_said_of_its_own_bench_file(write_bench: Callable[[dict[str, Any]], Path]):
    guide = Path(armtwin.hardware.__file__).parent
    setup = read_bench(write_bench(tomllib.loads((guide / "guide" / "bench.toml").read_text("utf-8"))))
    findings = [
        judge_joint(setup, 0, np.array([1.01, 0.0, 0.0])),
        judge_joint(setup, 1, np.array([0.0, -1.0, 0.0])),
        *judge_zeros(setup, np.radians([0.0, 0.0, 14.0])),
    ]

    shown = [f"{'ok  ' if finding.good else 'FAIL'}  {finding.text}" for finding in findings]
    assert "\n".join(f"    {line}" for line in shown) in (guide / "bench-guide.md").read_text("utf-8")
