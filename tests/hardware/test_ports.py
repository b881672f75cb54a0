from __future__ import annotations

import grp
import os
import pty
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from hardware.ports import open_port
from models.errors import InputError

NOBODY = 65534


@pytest.fixture
def port() -> Iterator[str]:
    master, slave = pty.openpty()
    yield os.ttyname(slave)
    os.close(slave)
    os.close(master)


@contextmanager
def without_privileges() -> Iterator[None]:
    if os.geteuid() != 0:
        yield
        return
    os.seteuid(NOBODY)
    try:
        yield
    finally:
        os.seteuid(0)


def test_a_port_carries_bytes(port: str) -> None:
    with open_port(port, 0.1) as opened:
        assert opened.write(b"\0\1\2") == 3


def test_a_missing_port_is_named_with_what_there_is_instead() -> None:
    with pytest.raises(
        InputError, match=r"/dev/ttyACM77: it does not exist; USB serial ports found: .*Check the cable"
    ):
        open_port("/dev/ttyACM77", 0.1)


def test_a_forbidden_port_names_the_group_to_join(port: str) -> None:
    if os.geteuid() == 0:
        os.chown(port, 0, grp.getgrnam("dialout").gr_gid)
    Path(port).chmod(0o000)
    with without_privileges(), pytest.raises(InputError, match=r"no permission .* usermod -aG dialout \$USER"):
        open_port(port, 0.1)


def test_a_busy_port_says_that_another_program_has_it(port: str) -> None:
    with open_port(port, 0.1), pytest.raises(InputError, match="another program is using it"):
        open_port(port, 0.1)


def test_a_port_is_free_again_once_closed(port: str) -> None:
    open_port(port, 0.1).close()
    open_port(port, 0.1).close()


def test_a_file_is_no_serial_port(tmp_path: Path) -> None:
    path = tmp_path / "ttyACM0"
    path.write_text("not a port")
    with pytest.raises(InputError, match="cannot be used as a serial port"):
        open_port(str(path), 0.1)
