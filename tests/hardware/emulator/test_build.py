from __future__ import annotations

from pathlib import Path

import pytest

from armtwin.hardware.emulator import build, missing_packages
from armtwin.models.errors import JobError


def test_missing_packages_are_named_with_the_command(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    reason = missing_packages()
    assert reason is not None
    assert reason.startswith("the firmware emulator needs packages: sudo apt-get install ")
    assert {"gcc", "make", "gcc-avr"} <= set(reason.split())


def test_without_the_packages_a_build_is_refused_with_the_command(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(JobError, match="apt-get install"):
        build.build()


@pytest.mark.avr
def test_a_build_is_kept_outside_the_source_tree_and_used_again(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    first = build.build()
    assert tmp_path in first.firmware.parents
    assert first.firmware.read_bytes()[:4] == b"\x7fELF"
    built_at = first.host.stat().st_mtime_ns
    assert build.build() == first
    assert first.host.stat().st_mtime_ns == built_at


@pytest.mark.avr
def test_a_failed_build_says_what_the_compiler_said_and_leaves_nothing(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    broken = tmp_path / "sketch"
    broken.mkdir()
    (broken / "Makefile").write_bytes((build.FIRMWARE / "Makefile").read_bytes())
    (broken / "armtwin_firmware.ino").write_text("void setup() { no_such_function(); }\nvoid loop() {}\n")
    monkeypatch.setattr(build, "FIRMWARE", broken)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    with pytest.raises(JobError, match="no_such_function"):
        build.build()
    assert [path.name for path in build.cache_folder().iterdir()] == ["lock"]
