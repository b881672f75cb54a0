"""The whole check on the emulated bench, once as wired and once with a file that says it wrong."""

import signal
import subprocess
import sys
import time
import tomllib
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import tomli_w

from armtwin.hardware.bench.bench_file import read_bench
from armtwin.hardware.bench.hardware_bench import HardwareBench
from armtwin.hardware.emulator import missing_packages
from armtwin.models.errors import InputError, JobError
from armtwin.scenarios.commands.bench_check import bench_check_command, check_bench
from armtwin.scenarios.emulated_bench import EmulatedBench

pytestmark = [
    pytest.mark.avr,
    pytest.mark.slow,
    pytest.mark.skipif(bool(missing_packages()), reason=missing_packages() or "present"),
]

PATIENCE_S = 60.0  # only a failing test waits so long


@pytest.fixture(scope="module")
def emulated() -> Iterator[EmulatedBench]:
    with EmulatedBench() as running:
        yield running


def test_a_bench_wired_as_its_file_says_is_well(emulated: EmulatedBench):
    findings = check_bench(read_bench(emulated.bench_file))

    assert [finding.good for finding in findings] == [True, True, True, True]


def test_a_limp_arm_that_hangs_off_its_rest_pose_is_no_fault_of_the_wiring(emulated: EmulatedBench):
    setup = read_bench(emulated.bench_file)
    with HardwareBench(setup) as bench:
        bench.move(np.array([0.15, 0.0, 0.0]))  # where it stays when the servos are detached

    findings = check_bench(setup)

    assert [finding.text for finding in findings if not finding.good] == []


def test_wrong_direction_and_exchanged_plugs_are_told_apart(emulated: EmulatedBench):
    table = tomllib.loads(emulated.bench_file.read_text())
    table["joints"][0]["direction"] *= -1
    table["joints"][1]["servo"], table["joints"][2]["servo"] = 3, 2
    wrong = emulated.bench_file.with_name("wrong.toml")
    wrong.write_text(tomli_w.dumps(table))

    texts = [finding.text for finding in check_bench(read_bench(wrong)) if not finding.good]

    assert "joint 1 turns the wrong way: set its direction = 1" in texts
    assert any(text.startswith("joint 2 turns joint 3 instead") for text in texts)
    assert any(text.startswith("joint 3 turns joint 2 instead") for text in texts)


def test_a_bench_that_allows_smaller_steps_only_is_checked_by_those(emulated: EmulatedBench):
    setup = read_bench(emulated.bench_file)

    findings = check_bench(replace(setup, limits=replace(setup.limits, max_step_rad=0.06)))

    assert [finding.text for finding in findings if not finding.good] == []


@pytest.mark.parametrize("how", [signal.SIGTERM, signal.SIGHUP])
def test_a_check_ended_by_a_signal_detaches_at_once(emulated: EmulatedBench, how: signal.Signals):
    code = (
        "import sys; from armtwin.scenarios.commands import bench_check as b; b.bench_check_command(sys.argv[1], True)"
    )
    wait_until(lambda: np.isnan(emulated.widths_us()).all(), PATIENCE_S)  # whoever was before it has detached
    with subprocess.Popen([sys.executable, "-c", code, str(emulated.bench_file)], stderr=subprocess.PIPE) as host:
        wait_until(lambda: np.isfinite(emulated.widths_us()[:3]).all(), PATIENCE_S)
        host.send_signal(how)
        _, said = host.communicate(timeout=PATIENCE_S)

    assert b"KeyboardInterrupt" in said
    # The firmware's own way out, for a host that just dies, takes two seconds.
    wait_until(lambda: np.isnan(emulated.widths_us()).all(), 1.5)


def wait_until(condition: Callable[[], object], timeout_s: float) -> None:
    deadline = time.monotonic() + timeout_s
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.02)


def test_a_hidden_marker_is_said_so(emulated: EmulatedBench):
    emulated.tell("hide", "b")
    try:
        with pytest.raises(JobError, match="not all markers a, b, c, f are seen at rest"):
            check_bench(read_bench(emulated.bench_file))
    finally:
        emulated.tell("show", "b")


def test_nobody_at_the_terminal_is_refused(emulated: EmulatedBench, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    with (tmp_path / "empty").open("w+") as nobody:
        monkeypatch.setattr("sys.stdin", nobody)
        with pytest.raises(InputError, match="say --yes"):
            bench_check_command(str(emulated.bench_file))
