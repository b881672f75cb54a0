"""The whole check on the emulated bench, once as wired and once with a file that says it wrong."""

import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest
import tomli_w

from hardware.bench_file import read_bench
from hardware.emulator import missing_packages
from models.errors import InputError, JobError
from scenarios.commands.bench_check import bench_check_command, check_bench
from scenarios.emulated_bench import EmulatedBench

pytestmark = [
    pytest.mark.avr,
    pytest.mark.slow,
    pytest.mark.skipif(bool(missing_packages()), reason=missing_packages() or "present"),
]


@pytest.fixture(scope="module")
def emulated() -> Iterator[EmulatedBench]:
    with EmulatedBench() as running:
        yield running


def test_a_bench_wired_as_its_file_says_is_well(emulated: EmulatedBench):
    findings = check_bench(read_bench(emulated.bench_file))

    assert [finding.good for finding in findings] == [True, True, True, True]


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
