"""A whole run of a small scenario, through the command line as a person would start it."""

import json
import re
import subprocess
import sys
import time
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from armtwin.models.recordings.reader import read_recording
from armtwin.models.validation import CameraTable, check
from tests.support.disks import grow, mounted

# One worker of pytest-xdist makes the run that all of these look at.
pytestmark = [pytest.mark.xdist_group("integration-run"), pytest.mark.slow]

SMALL = """
schema = "armtwin.scenario/1"
title = "A small run"
about = "Few poses <of everything> & quick."
seed = 5
board_views = 5
gauge_lengths_mm = [30.0]
gauge_placements = 2

[geometry]
length_errors_mm = [6.7, 4.6, -0.7, 1.0]
joint_errors_rad = [0.02, 0.018, 0.083]

[trajectories.circle]
kind = "circle"
radius_mm = 25
samples = 10

[trajectories.line]
kind = "line"
start_mm = [-145, 25]
end_mm = [-115, 45]
samples = 4
"""
SAME = [
    "results.json",
    "truth.json",
    "camera.yaml",
    "diagnosis/diagnosis.json",
    "diagnosis/twin.toml",
    *(f"recordings/{name}/samples.csv" for name in ("before", "after", "extended")),
]

WORKERS_END_S = 5.0


def start(*arguments: object) -> "subprocess.Popen[str]":
    """Start armtwin in a process of its own."""
    return subprocess.Popen(
        [sys.executable, "-c", "from armtwin.scenarios.cli import main; main()", *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


@pytest.fixture(scope="module")
def scenario(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("scenario") / "small.toml"
    path.write_text(SMALL)
    return path


@pytest.fixture(scope="module")
def run(scenario: Path) -> Path:
    """Return the folder of an uninterrupted run."""
    out = scenario.parent / "out"
    process = start("run", scenario, "--out", out)
    _, errors = process.communicate()
    assert process.returncode == 0, errors
    return out


@pytest.fixture(scope="module")
def results(run: Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads((run / "results.json").read_text())
    return found


def test_the_calibrated_arm_follows_the_line_ten_times_better(results: dict[str, Any]) -> None:
    assert results["validation"]["mean_before_mm"] > 1.5
    assert results["validation"]["mean_after_mm"] < 0.1 * results["validation"]["mean_before_mm"]


def test_the_injected_lengths_are_found(results: dict[str, Any]) -> None:
    rows = {row["parameter"]: row for row in results["tables"]["4"]["rows"]}
    for name in ("delta_l1_mm", "delta_l2_mm", "delta_l4_mm"):
        found = rows[name]["least-squares"][-1]
        assert abs(found["value"] - rows[name]["truth_in_convention"]) < 0.4
        assert found["std"] > 0


def test_the_true_camera_is_found(results: dict[str, Any]) -> None:
    rows = {row["parameter"]: row for row in results["tables"]["2"]}
    assert abs(rows["fx"]["estimate"] / rows["fx"]["truth"] - 1) < 0.01
    assert rows["fx"]["std"] > 0


def test_the_sub_pixel_detector_measures_gauges_to_a_few_hundredths_of_a_millimetre(results: dict[str, Any]) -> None:
    row = next(row for row in results["tables"]["3"] if row["detector"] == "subpixel")
    assert row["n"] == 2
    assert abs(row["bias_mm"]) < 0.1


def test_six_of_seven_parameters_can_be_known_and_the_gauge_is_named(results: dict[str, Any]) -> None:
    found = results["tables"]["4"]["least-squares"][-1]
    assert found["identifiable"] == 6
    assert "l4" in found["gauge"][0]


def test_every_table_and_figure_of_the_paper_is_there(results: dict[str, Any]) -> None:
    assert set(results["tables"]) == {"1", "2", "3", "4"}
    assert {"3", "4", "5_and_6"} <= set(results["figures"])


def test_the_truth_holds_what_the_contract_names(run: Path) -> None:
    truth = json.loads((run / "truth.json").read_text())
    assert truth["link_lengths_mm"] == pytest.approx([126.7, 126.3, 37.3, 7.73])
    assert truth["joint_offsets_rad"] == [0.02, 0.018, 0.083]
    assert len(truth["base_in_board_mm"]) == 3
    assert truth["arm_plane_z_mm"] == -80.87
    assert truth["effects"] == []
    check(CameraTable, truth["camera"], "truth.json")


def test_the_recordings_can_be_read_and_hold_their_frames(run: Path) -> None:
    before, after = (read_recording(run / "recordings" / name) for name in ("before", "after"))
    assert (len(before), len(after)) == (14, 4)
    assert before.held_out == ("line",)
    assert before.has_time
    for recording in (before, after):
        for row in range(len(recording)):
            path = recording.frame_path(row)
            assert path is not None
            assert path.is_file()


def test_the_measured_pixels_are_those_of_the_frames(run: Path, tmp_path: Path) -> None:
    process = start("measure", run / "recordings" / "after", "--out", tmp_path / "again")
    _, errors = process.communicate()
    assert process.returncode == 0, errors
    ours, theirs = read_recording(tmp_path / "again"), read_recording(run / "recordings" / "after")
    for name, pixels in theirs.markers_px.items():
        assert np.allclose(ours.markers_px[name], pixels, rtol=0, atol=1e-9)


def test_the_papers_detector_measures_the_same_frames_nearby(run: Path, tmp_path: Path) -> None:
    process = start("measure", run / "recordings" / "after", "--method", "paper", "--out", tmp_path / "again")
    _, errors = process.communicate()
    assert process.returncode == 0, errors
    ours, theirs = read_recording(tmp_path / "again"), read_recording(run / "recordings" / "after")
    off = np.linalg.norm(ours.markers_px["a"] - theirs.markers_px["a"], axis=1)
    assert 0.01 < np.nanmean(off) < 5.0


class _Loads(HTMLParser):
    """Collects what a page would load, and its headings."""

    def __init__(self) -> None:
        super().__init__()
        self.loads: list[str] = []
        self.headings = 0

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        values = dict(attrs)
        self.headings += tag == "h2"
        if tag in ("script", "img", "link", "iframe", "source", "object", "embed"):
            self.loads += [str(values[key]) for key in ("src", "href", "data") if key in values]


def test_the_report_opens_offline(run: Path) -> None:
    page = (run / "report.html").read_text("utf-8")
    parser = _Loads()
    parser.feed(page)
    assert parser.headings >= 8
    assert parser.loads
    assert all(load.startswith("data:") for load in parser.loads)
    style = page[page.index("<style>") : page.index("</style>")]
    assert "url(" not in style
    assert "@import" not in style


def test_plotly_is_in_the_report_once(run: Path) -> None:
    page = (run / "report.html").read_text("utf-8")
    assert len(re.findall(r"plotly\.js v\d", page)) == 1


def test_the_scenarios_text_is_escaped_in_the_report(run: Path) -> None:
    page = (run / "report.html").read_text("utf-8")
    assert "Few poses &lt;of everything&gt; &amp; quick." in page
    assert "<of everything>" not in page


def _run_until(exists: Path, scenario: Path, out: Path) -> None:
    """Start a run and kill it as soon as a file or folder is there; its workers must end with it."""
    process = start("run", scenario, "--out", out)
    while not exists.exists() and process.poll() is None:
        time.sleep(0.02)
    process.kill()
    process.communicate(timeout=WORKERS_END_S)  # the workers hold our pipes open as long as they live
    assert not (out / "results.json").exists(), "it was done before it could be killed"


def test_a_run_killed_three_times_in_the_middle_goes_on_and_ends_with_the_same_bytes(
    run: Path, scenario: Path, tmp_path: Path
) -> None:
    """Killed while pictures are being taken, after the arm was calibrated, and after its twin was extended."""
    out = tmp_path / "killed"
    _run_until(out / "board", scenario, out)
    _run_until(out / "stages" / "calibration.json", scenario, out)
    _run_until(out / "stages" / "diagnose.json", scenario, out)
    again = start("run", scenario, "--out", out)
    _, errors = again.communicate()
    assert again.returncode == 0, errors
    for name in SAME:
        assert (out / name).read_bytes() == (run / name).read_bytes(), name
    assert not [path for path in out.rglob(".*") if path.name.endswith((".part", ".old"))]


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    with mounted(tmp_path, 28) as disk:
        yield disk


def test_a_full_disk_is_one_line_and_the_run_goes_on_when_there_is_room(
    run: Path, scenario: Path, small_disk: Path
) -> None:
    out = small_disk / "out"
    first = start("run", scenario, "--out", out)
    _, errors = first.communicate()
    assert first.returncode == 1
    said = [line for line in errors.splitlines() if line.startswith("armtwin: ")]
    assert len(said) == 1
    assert "No space left on device in stage" in said[0]
    assert "Traceback" not in errors
    assert not [path for path in out.rglob(".*") if path.name.endswith((".part", ".old"))]
    kept = {path: path.read_bytes() for path in (out / "stages").iterdir()}
    assert kept, "the disk was too small for one stage"

    grow(small_disk, 200)
    again = start("run", scenario, "--out", out)
    _, errors = again.communicate()
    assert again.returncode == 0, errors
    assert {path: path.read_bytes() for path in kept} == kept
    for name in SAME:
        assert (out / name).read_bytes() == (run / name).read_bytes(), name


def test_a_finished_run_is_not_done_again(run: Path, scenario: Path) -> None:
    stamps = {path: path.stat().st_mtime_ns for path in (run / "stages").iterdir()}
    process = start("run", scenario, "--out", run)
    assert process.wait() == 0
    assert {path: path.stat().st_mtime_ns for path in (run / "stages").iterdir()} == stamps
