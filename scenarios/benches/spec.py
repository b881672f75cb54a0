"""Which bench is meant: one kind, said on the command line or in a bench file.

simulated                   the ideal bench, nothing wrong with it
geometric, my-scenario.toml a scenario, or a twin.toml's simulated bench
emulated                    the real firmware on an emulated board, filmed
bench.toml                  what its key `kind` says, a hardware bench by default
http://127.0.0.1:8000/      a bench that somebody serves
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Literal
from urllib.parse import urlsplit

from pydantic import Field

from armtwin.hardware.bench.bench_file import BenchSetup, beside, read_bench
from armtwin.models.arm import Arm, read_arm
from armtwin.models.errors import InputError, nearest
from armtwin.models.toml_reader import read_toml
from armtwin.models.validation import Strict, check, short
from armtwin.scenarios.emulated_bench import MAX_SPEED, MIN_SPEED
from armtwin.scenarios.scenario import ScenarioFile, builtin_scenarios, read_scenario

SIMULATED, EMULATED = "simulated", "emulated"
# The bench of `--bench simulated`.
IDEAL_SCENARIO = "ideal"
KINDS = "'simulated', a scenario, 'emulated', a bench file (TOML), or the address of a served bench (http://...)"

_BENCH_SCHEMA = "armtwin.bench/"
_SCENARIO_SCHEMAS = ("armtwin.scenario/", "armtwin.twin/")


@dataclass(frozen=True, eq=False)
class SimulatedSpec:
    """The simulated bench of a scenario."""

    scenario: ScenarioFile


@dataclass(frozen=True)
class EmulatedSpec:
    """The emulated bench at `speed` times real time, with the paper's arm or another."""

    speed: float = 1.0
    arm: Arm | None = None


@dataclass(frozen=True, eq=False)
class HardwareSpec:
    """An Arduino and a webcam."""

    setup: BenchSetup


@dataclass(frozen=True)
class RemoteSpec:
    """A served bench and the token that it asks for."""

    url: str
    token: str


BenchSpec = SimulatedSpec | EmulatedSpec | HardwareSpec | RemoteSpec


class _SimulatedFile(Strict):
    schema_: Literal["armtwin.bench/1"] = Field(alias="schema")
    kind: Literal["simulated"]
    scenario: Annotated[str, Field(min_length=1, max_length=1000)] = IDEAL_SCENARIO


class _EmulatedFile(Strict):
    schema_: Literal["armtwin.bench/1"] = Field(alias="schema")
    kind: Literal["emulated"]
    speed: Annotated[float, Field(ge=MIN_SPEED, le=MAX_SPEED)] = 1.0
    arm: Annotated[str, Field(min_length=1, max_length=1000)] | None = None


class _RemoteFile(Strict):
    schema_: Literal["armtwin.bench/1"] = Field(alias="schema")
    kind: Literal["remote"]
    url: Annotated[str, Field(pattern=r"^https?://", max_length=2000)]


def bench_spec(said: str, *, token: str | None = None, speed: float | None = None) -> BenchSpec:
    """Return which bench is meant by what was said; raises `InputError`.

    `token` is asked for by a served bench alone, `speed` (times real time) goes with the emulated one alone.
    """
    spec = _by_word_or_file(said, token)
    if speed is not None and not isinstance(spec, EmulatedSpec):
        raise InputError("--speed: a bench goes at its own speed; leave it out, or use --bench emulated")
    return replace(spec, speed=speed) if isinstance(spec, EmulatedSpec) and speed is not None else spec


def _by_word_or_file(said: str, token: str | None) -> BenchSpec:
    if said == EMULATED:
        return EmulatedSpec()
    if said.startswith(("http://", "https://")):
        return _remote(said, token)
    if said == SIMULATED:
        return SimulatedSpec(read_scenario(IDEAL_SCENARIO))
    if said in builtin_scenarios():
        return SimulatedSpec(read_scenario(said))
    path = Path(said)
    if path.suffix == ".toml" or path.is_file():
        return _in_file(path, token)
    hint = nearest(said, [SIMULATED, EMULATED, *builtin_scenarios()])
    raise InputError(f"--bench: '{said[:80]}' is no bench; {KINDS} is wanted{hint}")


def _in_file(path: Path, token: str | None) -> BenchSpec:
    table = read_toml(path)
    schema, kind = str(table.get("schema")), table.get("kind", "hardware")
    if schema.startswith(_SCENARIO_SCHEMAS):
        return SimulatedSpec(read_scenario(str(path)))
    if not schema.startswith(_BENCH_SCHEMA) or kind == "hardware":
        return HardwareSpec(read_bench(path))
    if kind == "simulated":
        name = check(_SimulatedFile, table, path.name).scenario
        known = name in builtin_scenarios()
        return SimulatedSpec(read_scenario(name if known else str(beside(path, "scenario", name))))
    if kind == "emulated":
        emulated = check(_EmulatedFile, table, path.name)
        arm = None if emulated.arm is None else read_arm(beside(path, "arm", emulated.arm))
        return EmulatedSpec(emulated.speed, arm)
    if kind == "remote":
        return _remote(check(_RemoteFile, table, path.name).url, token)
    raise InputError(f"{path.name}: kind: found {short(kind)}, one of hardware, simulated, emulated, remote is wanted")


def _remote(url: str, token: str | None) -> RemoteSpec:
    try:
        host = urlsplit(url).hostname
    except ValueError:  # half an IPv6 address
        host = None
    if not host:
        raise InputError(f"--bench: '{url[:80]}' is no address of a served bench; http://HOST:PORT/ is wanted")
    if not token:
        raise InputError(f"--token: {url[:80]} asks for the one that `armtwin serve` printed (or set ARMTWIN_TOKEN)")
    return RemoteSpec(url, token)
