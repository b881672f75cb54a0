"""Which bench is meant: by a word, a scenario, a bench file of any kind, or an address."""

from __future__ import annotations

from pathlib import Path

import pytest
import tomli_w

from armtwin.models.errors import InputError
from armtwin.scenarios.benches.spec import EmulatedSpec, HardwareSpec, RemoteSpec, SimulatedSpec, bench_spec
from armtwin.scenarios.scenario import builtin_scenarios
from tests.support.bench import bench_table, write_bench

__all__ = ["bench_table", "write_bench"]


def file_of(folder: Path, **keys: object) -> str:
    path = folder / "bench.toml"
    path.write_text(tomli_w.dumps({"schema": "armtwin.bench/1", **keys}))
    return str(path)


def title_of(said: str) -> str:
    spec = bench_spec(said)
    assert isinstance(spec, SimulatedSpec)
    return spec.scenario.title


def test_a_word_a_scenario_and_a_scenario_file_are_simulated_benches(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(builtin_scenarios()["geometric"].read_text("utf-8"))
    assert title_of("simulated") == title_of("ideal")
    assert title_of("geometric") == title_of(str(path)) != title_of("ideal")


def test_a_bench_file_names_its_kind(tmp_path: Path) -> None:
    assert title_of(file_of(tmp_path, kind="simulated", scenario="noisy")) == title_of("noisy")
    assert title_of(file_of(tmp_path, kind="simulated")) == title_of("ideal")
    assert bench_spec(file_of(tmp_path, kind="emulated", speed=2.0)) == EmulatedSpec(2.0)
    remote = file_of(tmp_path, kind="remote", url="http://127.0.0.1:8000/")
    assert bench_spec(remote, token="secret") == RemoteSpec("http://127.0.0.1:8000/", "secret")


def test_a_bench_file_without_a_kind_is_a_hardware_bench(bench_table, write_bench) -> None:  # type: ignore[no-untyped-def]
    assert isinstance(bench_spec(str(write_bench(bench_table))), HardwareSpec)
    assert isinstance(bench_spec(str(write_bench({**bench_table, "kind": "hardware"}))), HardwareSpec)


@pytest.mark.parametrize(
    ("said", "message"),
    [
        ("emulate", r"'emulate' is no bench.*a bench file \(TOML\), or the address.*did you mean 'emulated'"),
        ("http://", r"'http://' is no address of a served bench; http://HOST:PORT/ is wanted"),
        ("http://[::1/", r"is no address of a served bench"),
        ("missing.toml", r"missing.toml: no such file"),
        ("http://127.0.0.1:1/", r"--token: http://127.0.0.1:1/ asks for the one that `armtwin serve` printed"),
    ],
)
def test_what_is_no_bench_is_told_with_what_is(said: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        bench_spec(said)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"kind": "imaginary"}, "bench.toml: kind: found 'imaginary', one of hardware, simulated, emulated, remote"),
        ({"kind": "simulated", "scenario": "../secret.toml"}, "bench.toml: scenario"),
        ({"kind": "emulated", "speed": 9.0}, "bench.toml: speed"),
        ({"kind": "emulated", "port": "/dev/ttyACM0"}, "bench.toml: unknown key 'port'"),
        ({"kind": "remote", "url": "bench.example"}, "bench.toml: url"),
    ],
)
def test_a_wrong_key_of_a_bench_file_is_named(tmp_path: Path, keys: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        bench_spec(file_of(tmp_path, **keys), token="secret")


def test_only_the_emulated_bench_has_a_speed() -> None:
    assert bench_spec("emulated", speed=2.0) == EmulatedSpec(2.0)
    with pytest.raises(InputError, match="--speed: a bench goes at its own speed"):
        bench_spec("simulated", speed=2.0)
