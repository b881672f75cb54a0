"""Builds the firmware and the emulator's C host into a cache outside the source tree, once a version of them."""

from __future__ import annotations

import fcntl
import hashlib
import os
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

from armtwin.models.atomic import folder_aside
from armtwin.models.errors import JobError

EMULATOR = Path(__file__).parent
FIRMWARE = EMULATOR.parent / "firmware" / "armtwin_firmware"
APT = "sudo apt-get install"
# What shows that a Debian package is there: a program on the path, or a file.
PROGRAMS = {"gcc": "gcc", "make": "make", "avr-g++": "gcc-avr"}
FILES = {
    "/usr/lib/avr/include/avr/io.h": "avr-libc",
    "/usr/share/arduino/hardware/arduino/avr/cores/arduino/Arduino.h": "arduino-core-avr",
    "/usr/include/simavr/sim_avr.h": "libsimavr-dev",
    "/usr/include/libelf.h": "libelf-dev",
}


@dataclass(frozen=True)
class Built:
    """The firmware, linked for the ATmega328P, and the program that emulates it."""

    firmware: Path
    host: Path


def missing_packages() -> str | None:
    """None if all is there to build and run the emulator, else one sentence with the command that installs it."""
    missing = [package for program, package in PROGRAMS.items() if shutil.which(program) is None]
    missing += [package for path, package in FILES.items() if not Path(path).is_file()]
    return f"the firmware emulator needs packages: {APT} {' '.join(missing)}" if missing else None


def cache_folder() -> Path:
    """Where builds are kept: `$XDG_CACHE_HOME/armtwin/emulator`, by default under `~/.cache`."""
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "armtwin" / "emulator"


def build() -> Built:
    """Build both if this version of their sources is not built yet; raises JobError if a package or the build fails."""
    reason = missing_packages()
    if reason is not None:
        raise JobError(reason)
    folder = cache_folder() / _fingerprint()
    built = Built(folder / "armtwin_firmware.elf", folder / "host")
    folder.parent.mkdir(parents=True, exist_ok=True)
    with (folder.parent / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)  # tests run in several processes; the first builds, the others wait
        if built.firmware.is_file() and built.host.is_file():
            return built
        with folder_aside(folder) as aside:
            _make(["make", "-C", str(FIRMWARE), f"BUILD={aside}", str(aside / built.firmware.name)])
            _make(["make", "-C", str(EMULATOR), f"BUILD={aside}"])
    return built


def _fingerprint() -> str:
    digest = hashlib.sha256()
    for folder in (FIRMWARE, EMULATOR):
        for path in sorted(folder.iterdir()):
            if path.suffix in (".ino", ".h", ".c", ".cpp") or path.name == "Makefile":
                digest.update(path.name.encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()[:16]


def _make(command: list[str]) -> None:
    run = subprocess.run(command, capture_output=True, text=True, check=False)  # noqa: S603 (a fixed command)
    if run.returncode != 0:
        raise JobError(f"'{' '.join(command)}' failed:\n{run.stderr.strip()}")
