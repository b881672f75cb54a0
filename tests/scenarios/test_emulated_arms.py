"""The emulated bench with other arms than the paper's: two servos and six, through the real firmware to the picture."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import tomli_w

from armtwin.hardware.bench.bench_check import run_bench_check
from armtwin.hardware.bench.bench_file import read_bench
from armtwin.hardware.bench.hardware_bench import HardwareBench
from armtwin.hardware.emulator import missing_packages
from armtwin.models.arm import Arm
from armtwin.models.kinematics import marker_positions
from armtwin.scenarios.benches.door import open_bench
from armtwin.scenarios.benches.spec import EmulatedSpec, bench_spec
from armtwin.scenarios.emulated_bench import EmulatedBench, world_of
from armtwin.scenarios.marker_finder import marker_finder

pytestmark = [
    pytest.mark.avr,
    pytest.mark.skipif(bool(missing_packages()), reason=missing_packages() or "present"),
]

LENGTHS_MM = {2: [110.0, 95.0], 6: [60.0, 50.0, 45.0, 45.0, 40.0, 40.0]}


def arm_of(n_joints: int) -> Arm:
    return Arm("mine", np.array(LENGTHS_MM[n_joints]), np.zeros(2))


@pytest.mark.parametrize("n_joints", [2, 6])
def test_an_arm_of_so_many_joints_goes_where_it_is_sent(n_joints: int) -> None:
    arm = arm_of(n_joints)
    q = 0.2 * np.cos(np.arange(n_joints))
    with EmulatedBench(arm=arm, speed=2.0) as emulated:
        setup = read_bench(emulated.bench_file)
        with HardwareBench(setup, marker_finder(setup.arm, setup.camera, setup.arm_plane_z_mm)) as bench:
            bench.move(q)
            seen = bench.posture()
    assert seen is not None
    # What the picture shows of the nominal arm's angles: the command, but for the errors that this arm was built with.
    world = world_of(arm)
    built = np.diff(marker_positions(arm, q[None], world.deviation)[0], axis=0)
    turns = np.diff(np.arctan2(built[:, 1], built[:, 0]), prepend=0.0)
    np.testing.assert_allclose(seen, turns, atol=np.radians(0.3))


@pytest.mark.slow
def test_the_check_of_a_bench_with_six_joints_finds_all_of_them_well() -> None:
    with EmulatedBench(arm=arm_of(6), speed=2.0) as emulated:
        setup = read_bench(emulated.bench_file)
        with HardwareBench(setup, marker_finder(setup.arm, setup.camera, setup.arm_plane_z_mm)) as bench:
            findings = run_bench_check(bench)
    assert [finding.text for finding in findings if not finding.good] == []


def test_a_bench_file_names_the_arm_of_an_emulated_bench(tmp_path: Path) -> None:
    arm_file = {"schema": "armtwin.arm/1", "name": "mine", "link_lengths_mm": LENGTHS_MM[2]}
    (tmp_path / "arm.toml").write_text(tomli_w.dumps(arm_file))
    bench_file = tmp_path / "bench.toml"
    bench_file.write_text(tomli_w.dumps({"schema": "armtwin.bench/1", "kind": "emulated", "arm": "arm.toml"}))
    spec = bench_spec(str(bench_file), speed=2.0)
    assert isinstance(spec, EmulatedSpec)
    assert spec.speed == 2.0
    assert open_bench(spec).description.arm.n_joints == 2
