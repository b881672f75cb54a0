"""One door, benches of every kind behind it, and the same capture on each."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from armtwin.hardware.emulator import missing_packages
from armtwin.models.bench import Bench
from armtwin.models.errors import InputError, RecordingError
from armtwin.models.plan import Plan, write_plan
from armtwin.models.recordings.reader import read_recording
from armtwin.scenarios.benches.door import bench_setup, open_bench
from armtwin.scenarios.benches.spec import bench_spec
from armtwin.scenarios.commands.capture import capture, capture_command
from tests.scenarios.serving.conftest import TOKEN, Served, served
from tests.support.bench import bench_table, write_bench

__all__ = ["bench_table", "served", "write_bench"]

POSES = np.array([[0.1, 0.1, -0.1], [0.2, 0.0, 0.1], [0.0, -0.1, 0.2]])


def plan_file(folder: Path, n: int = 3, payload_kg: float = 0.0) -> str:
    path = folder / f"plan{n}.csv"
    write_plan(path, Plan(np.full(n, "t"), POSES[:n], np.full(n, payload_kg)))
    return str(path)


@pytest.mark.parametrize("said", ["simulated", "geometric", "emulated"])
def test_a_bench_by_name_is_a_bench(said: str) -> None:
    bench = open_bench(said)
    assert isinstance(bench, Bench)
    assert bench.detached
    assert bench.notes == ()
    assert bench.description.kind in ("simulated", "emulated")
    assert bench.description.hangs_loads


def test_a_hardware_bench_hangs_loads_only_where_someone_does(bench_table, write_bench) -> None:  # type: ignore[no-untyped-def]
    spec = bench_spec(str(write_bench(bench_table)))
    hung: list[float] = []
    attended = open_bench(spec, hang_by=hung.append)
    attended.hang(0.05)
    assert hung == [0.05]
    assert attended.description.hangs_loads
    alone = open_bench(spec)
    assert not alone.description.hangs_loads
    with pytest.raises(InputError, match="nobody is there to hang it"):
        alone.hang(0.05)


def test_a_capture_on_a_simulated_bench_is_a_whole_recording(tmp_path: Path) -> None:
    capture_command("geometric", plan_file(tmp_path, payload_kg=0.02), tmp_path / "out")
    recording = read_recording(tmp_path / "out")
    np.testing.assert_array_equal(recording.q_cmd, POSES)
    np.testing.assert_allclose(recording.time_s, [1.5, 3.0, 4.5])
    assert recording.commanded_s is not None
    np.testing.assert_allclose(recording.commanded_s, [0.0, 1.5, 3.0])
    assert all((path := recording.frame_path(row)) is not None and path.is_file() for row in range(3))


def test_a_capture_that_broke_off_goes_on_with_its_clock_and_on_the_same_bench_alone(tmp_path: Path) -> None:
    whole = plan_file(tmp_path, 3)
    out = tmp_path / "out"
    capture_command("geometric", whole, out)
    lines = (out / "samples.csv").read_text().splitlines(keepends=True)
    (out / "samples.csv").write_text("".join(lines[:3]))  # as a kill -9 after the second pose leaves it
    (out / "frames" / "000002.png").unlink()

    with pytest.raises(RecordingError, match=r"another servo map or on another bench \(actuation\.scenario"):
        capture_command("noisy", whole, out)
    capture_command("geometric", whole, out)
    assert (np.diff(read_recording(out).time_s) > 0).all()


@pytest.mark.xdist_group("serving")
def test_a_capture_on_a_served_bench_is_the_one_on_the_bench_itself(served: Served, tmp_path: Path) -> None:
    spec = bench_spec(served.url, token=TOKEN)
    capture(open_bench(spec), plan_file(tmp_path), tmp_path / "remote", None)
    capture_command("simulated", plan_file(tmp_path), tmp_path / "here")
    there, here = read_recording(tmp_path / "remote"), read_recording(tmp_path / "here")
    for name in ("time_s", "commanded_s", "q_cmd", "trajectory"):
        np.testing.assert_array_equal(getattr(there, name), getattr(here, name))
    for row in range(len(POSES)):
        paths = [folder.frame_path(row) for folder in (there, here)]
        assert paths[0] is not None
        assert paths[1] is not None
        assert paths[0].read_bytes() == paths[1].read_bytes()
    assert (tmp_path / "remote" / "recording.json").read_bytes() == (tmp_path / "here" / "recording.json").read_bytes()


@pytest.mark.avr
@pytest.mark.slow
@pytest.mark.skipif(bool(missing_packages()), reason=missing_packages() or "present")
def test_the_emulated_bench_starts_when_it_is_connected_and_ends_when_it_is_closed() -> None:
    with open_bench(bench_spec("emulated", speed=2.0)) as bench:
        assert bench.clock_origin_s is not None
        bench.hang(0.01)
        bench.move(POSES[0])
        frame = bench.capture()
        assert frame.commanded_s is not None
        assert 0.0 < frame.commanded_s < frame.time_s
        assert not bench.detached
    assert bench.detached


def test_what_has_no_wires_is_not_checked_for_them() -> None:
    with pytest.raises(InputError, match="'geometric' has no wires to look at"), bench_setup("geometric"):
        pass
