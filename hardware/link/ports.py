"""Opening a serial port, and saying plainly why it cannot be opened."""

from __future__ import annotations

import contextlib
import errno
import grp
import os
import termios
from pathlib import Path

import serial
from serial.tools import list_ports

from armtwin.models.errors import InputError

BAUD = 115200  # bit/s: the fastest rate that an Uno's 16 MHz clock meets within 2.1 %
DEFAULT_GROUP = "dialout"  # owns serial ports on Debian and Ubuntu


# Where Linux lists USB devices.
USB_DEVICES = Path("/sys/bus/usb/devices")
# WCH's CH340 and CH341, as copies of the Uno have them.
_CH340 = {("1a86", "7523"), ("1a86", "5523")}
BRLTTY = (
    "a CH340 serial chip is plugged in and has no port: brltty, a driver of Braille displays, takes it on Ubuntu and "
    "Debian; 'sudo apt-get remove brltty' (or 'sudo systemctl mask brltty-udev.service'), then plug it in again"
)


def open_port(port: str, poll_s: float) -> serial.Serial:
    """Open `port` at 115200 baud, 8N1, exclusively; reads return after `poll_s` seconds at the latest.

    Opening resets an Uno. Raises InputError, saying what to do, if the port is missing, forbidden, in use or no
    serial port at all.
    """
    try:
        return serial.Serial(port, BAUD, timeout=poll_s, write_timeout=1.0, exclusive=True)
    except (serial.SerialException, OSError) as error:
        raise InputError(_explain(port, error)) from None


def candidates() -> list[str]:
    """Serial ports of this machine that look like an Arduino's, each with its description."""
    return [f"{port.device} ({port.description})" for port in list_ports.comports() if port.vid is not None]


def has_lost_ch340(usb: Path = USB_DEVICES) -> bool:
    """Whether a CH340 is plugged in that has no serial port, as when another driver has taken it from the kernel's."""
    for device in usb.glob("*"):
        with contextlib.suppress(OSError):
            chip = tuple((device / name).read_text("ascii").strip() for name in ("idVendor", "idProduct"))
            if chip in _CH340 and not list(device.glob("*/ttyUSB*")):
                return True
    return False


def _explain(port: str, error: OSError) -> str:
    if error.errno == errno.ENOENT:
        if has_lost_ch340():
            return f"serial port {port}: it does not exist; {BRLTTY}"
        found = ", ".join(candidates()) or "none"
        return f"serial port {port}: it does not exist; USB serial ports found: {found}. Check the cable and the name"
    if error.errno in (errno.EACCES, errno.EPERM):
        group = _group(port)
        return (
            f"serial port {port}: no permission to open it; join its group with 'sudo usermod -aG {group} $USER', "
            "then log out and in again"
        )
    if error.errno in (errno.EAGAIN, errno.EWOULDBLOCK, errno.EBUSY) or "exclusively lock" in str(error):
        return (
            f"serial port {port}: another program is using it; close it (another armtwin, the Arduino IDE's serial "
            f"monitor); 'fuser -v {port}' names it"
        )
    number = _system_number(error)
    path = Path(port)
    kind = "a folder" if path.is_dir() else "a file" if path.is_file() else "a device of another kind"
    if path.is_dir() or path.is_file() or number in (errno.ENOTTY, errno.EINVAL):  # it takes no speed
        found = ", ".join(candidates()) or "none"
        return f"serial port {port}: it is {kind}, no serial port; USB serial ports found: {found}"
    why = "no reason given" if number is None else os.strerror(number)
    return f"serial port {port}: it cannot be used ({why}); pull its cable, plug it in again and start again"


def _system_number(error: OSError) -> int | None:
    """Return the system's error number; of a port that cannot be set pyserial keeps it in what it caught alone."""
    cause = error.__context__
    return int(cause.args[0]) if error.errno is None and isinstance(cause, termios.error) else error.errno


def _group(port: str) -> str:
    with contextlib.suppress(OSError, KeyError):
        group = grp.getgrgid(Path(port).stat().st_gid).gr_name
        # Joining a person's own or root's group would open far more than a port: there the udev rule is missing.
        if group not in ("root", "tty"):
            return group
    return DEFAULT_GROUP
