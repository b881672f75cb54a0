"""What a bench needs of this machine, one line each, with the remedy where it is missing."""

from __future__ import annotations

import grp
import os
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from armtwin.hardware.bench.bench_file import BenchSetup
from armtwin.hardware.camera.frame_quality import fault_of
from armtwin.hardware.camera.stillness import to_grey
from armtwin.hardware.camera.webcam import Webcam
from armtwin.hardware.link.ports import BRLTTY, USB_DEVICES, candidates, has_lost_ch340
from armtwin.hardware.link.servo_link import ServoLink, WrongFirmwareError
from armtwin.models.camera import Camera
from armtwin.models.errors import ArmtwinError

# A recording of the paper's plan: 150 pictures of 1.3 MB, and as much again to spare.
_WANTED_BYTES = 400e6
_GROUPS = {"dialout": "serial ports", "video": "cameras"}


@dataclass(frozen=True)
class Check:
    """One line: `good` is None where nothing could be checked; `text` holds what was found, or what to do."""

    name: str
    good: bool | None
    text: str


def run_checks(setup: BenchSetup | None, folder: Path, renderer: Callable[[], str]) -> list[Check]:
    """Check everything; `renderer` draws a frame and says how, raising `ArmtwinError` where it cannot.

    Without a setup the serial port and the camera are only looked for. Nothing moves: the servos are not armed.
    """
    checks = [_guarded("renderer", renderer), check_permissions()]
    if setup is None:
        checks += [look_for_ports(), Check("firmware", None, "not asked: name the port in a bench file, --bench")]
        checks.append(look_for_cameras())
    else:
        checks += check_board(setup.port)
        checks.append(_guarded("camera", lambda: describe_camera(setup)))
    checks.append(check_disk(folder))
    return checks


def check_board(port: str) -> list[Check]:
    """Open the serial port and ask the board who it is."""
    try:
        with ServoLink(port) as link:
            hello = link.hello()
    except WrongFirmwareError as error:
        return [Check("serial port", True, f"{port} answers"), Check("firmware", False, str(error))]
    except ArmtwinError as error:
        return [Check("serial port", False, str(error)), Check("firmware", None, "not known: no board was heard")]
    major, minor = hello.firmware_version
    return [
        Check("serial port", True, f"{port} answers"),
        Check(
            "firmware",
            True,
            f"version {major}.{minor}, protocol {hello.protocol_version}, drives up to {hello.n_servos} servos",
        ),
    ]


def describe_camera(setup: BenchSetup) -> str:
    """Open the camera, set it, look at a picture; raises `ArmtwinError` with what is wrong."""
    camera: Camera = setup.camera
    with Webcam(setup.camera_settings, camera.image_width, camera.image_height, setup.quality.frozen_s) as webcam:
        fault = fault_of(to_grey(webcam.newest().image), setup.quality)
        if fault is not None:
            raise ArmtwinError(f"{webcam.source}: {fault}")
        return "; ".join([f"{webcam.source} gives {camera.image_width}x{camera.image_height}", *webcam.notes])


def look_for_ports(usb: Path = USB_DEVICES) -> Check:
    """List the USB serial ports; a CH340 whose port was taken away is named with who takes it."""
    found = candidates()
    if has_lost_ch340(usb):
        return Check("serial port", False, BRLTTY)
    if found:
        return Check("serial port", None, f"found {', '.join(found)}; name one in a bench file, --bench")
    return Check("serial port", False, "no USB serial port found: plug in the Arduino, use a cable with data lines")


def look_for_cameras() -> Check:
    """List the V4L2 devices."""
    found = sorted(str(path) for path in Path("/dev").glob("video*"))
    if found:
        return Check("camera", None, f"found {', '.join(found)}; name one in a bench file, --bench")
    return Check("camera", False, "no camera found: plug it in; 'v4l2-ctl --list-devices' names what the system sees")


def check_permissions() -> Check:
    """Check that the user is in the groups that own serial ports and cameras; the superuser needs none."""
    if os.geteuid() == 0:
        return Check("permissions", True, "superuser, who needs no group")
    mine = {_group_name(number) for number in os.getgroups()}
    missing = [name for name in _GROUPS if name not in mine and _exists(name)]
    if missing:
        what = " and ".join(_GROUPS[name] for name in missing)
        return Check(
            "permissions",
            False,
            f"no access to {what}: 'sudo usermod -aG {','.join(missing)} $USER', then log out and in again",
        )
    return Check("permissions", True, f"in {', '.join(name for name in _GROUPS if name in mine)}")


def check_disk(folder: Path) -> Check:
    """Check that a recording has room on the disk of `folder`."""
    free = shutil.disk_usage(folder).free
    good = free >= _WANTED_BYTES
    remedy = "" if good else f"; a recording wants {_WANTED_BYTES / 1e6:.0f} MB: make room, or record elsewhere"
    return Check("disk", good, f"{free / 1e9:.1f} GB free in {folder}{remedy}")


def _guarded(name: str, describe: Callable[[], str]) -> Check:
    try:
        return Check(name, True, describe())
    except ArmtwinError as error:
        return Check(name, False, str(error))


def _group_name(number: int) -> str:
    try:
        return grp.getgrgid(number).gr_name
    except KeyError:  # a group without a name, as in containers
        return str(number)


def _exists(name: str) -> bool:
    try:
        grp.getgrnam(name)
    except KeyError:
        return False
    return True
