from __future__ import annotations

import grp
import os
import pty
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from armtwin.hardware.link.ports import open_port
from armtwin.models.errors import InputError

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


@pytest.mark.parametrize(
    ("name", "kind"), [("file", "a file"), ("folder", "a folder"), ("pipe", "a device of another kind")]
)
def test_what_is_no_serial_port_is_called_what_it_is(tmp_path: Path, name: str, kind: str) -> None:
    (tmp_path / "file").write_text("not a port")
    (tmp_path / "folder").mkdir()
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(InputError) as error:
        open_port(str(tmp_path / name), 0.1)
    assert f"serial port {tmp_path / name}: it is {kind}, no serial port; USB serial ports found: " in str(error.value)


def test_a_path_through_a_file_says_why_in_the_systems_words(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match=r"it cannot be used \(Not a directory\); pull its cable"):
        open_port(str(tmp_path / "file" / "port"), 0.1)
