"""Each remedy, against real ports, streams and disks; what is looked for does not exist on purpose."""

import os
import pty
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from armtwin.hardware.doctor import check_board, check_disk, look_for_ports, run_checks
from armtwin.hardware.emulator import FirmwareEmulator, missing_packages
from armtwin.hardware.link.framing import encode
from armtwin.models.errors import JobError
from armtwin.scenarios.commands.doctor import describe_renderer, doctor_command
from tests.support.bench import bench_table, write_bench
from tests.support.scripted_board import HELLO, scripted_board

__all__ = ["bench_table", "write_bench"]


def test_renderer_says_how_long_a_frame_takes():
    assert describe_renderer().startswith("draws 1280x720 in ")


def test_without_a_bench_nothing_is_opened_and_every_line_has_a_name(tmp_path: Path):
    checks = run_checks(None, tmp_path, lambda: "draws")

    assert [check.name for check in checks] == [
        "renderer",
        "permissions",
        "serial port",
        "firmware",
        "camera",
        "disk",
    ]
    assert all("\n" not in check.text and check.text for check in checks)


def test_a_renderer_that_fails_is_a_line_and_not_the_end(tmp_path: Path):
    def broken() -> str:
        raise JobError("no off-screen OpenGL; install libegl1")

    checks = {check.name: check for check in run_checks(None, tmp_path, broken)}

    assert checks["renderer"].good is False
    assert "libegl1" in checks["renderer"].text
    assert checks["disk"].good


def test_missing_port_and_camera_are_named_with_remedies(
    bench_table: dict[str, Any],
    write_bench: Callable[[dict[str, Any]], Path],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
):
    bench_table["serial"]["port"] = str(tmp_path / "no-port")
    bench_table["camera"]["source"] = "/dev/video97"

    with pytest.raises(JobError, match="2 of 6 checks failed"):
        doctor_command(str(write_bench(bench_table)), tmp_path)

    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 6
    assert any(line.startswith("FAIL  serial port") and "Check the cable" in line for line in lines)
    assert any(line.startswith("FAIL  camera") and "/dev/video97" in line for line in lines)


@pytest.fixture
def silent_port() -> Iterator[str]:
    ours, theirs = pty.openpty()
    yield os.ttyname(theirs)
    os.close(ours)
    os.close(theirs)


def test_a_port_that_nobody_answers_on_asks_for_the_firmware(silent_port: str):
    port, firmware = check_board(silent_port)

    assert port.good is False
    assert "upload hardware/firmware/armtwin_firmware" in port.text
    assert firmware.good is None


@pytest.mark.parametrize(
    ("hello", "found"),
    [
        (b"\x01" + HELLO[1:], "speaks version 1 of the protocol"),
        (HELLO[:1] + b"\x03\x05" + HELLO[3:], "is version 3.5"),
    ],
    ids=["protocol", "firmware"],
)
def test_a_board_with_another_firmware_answers_and_is_told_how_to_get_the_right_one(hello: bytes, found: str):
    with scripted_board(lambda payload: encode(bytes((0x81, payload[1], 0)) + hello)) as name:
        port, firmware = check_board(name)

    assert port.good
    assert port.text == f"{name} answers"
    assert firmware.good is False
    assert found in firmware.text
    assert "upload hardware/firmware/armtwin_firmware" in firmware.text


@pytest.mark.avr
@pytest.mark.skipif(bool(missing_packages()), reason=missing_packages() or "present")
def test_the_real_firmware_names_its_version():
    with FirmwareEmulator(speed=4.0) as board:
        port, firmware = check_board(board.port)

    assert port.good
    assert firmware.good
    assert firmware.text == "version 2.0, protocol 2, drives up to 6 servos"


def usb_device(root: Path, name: str, *, vendor: str = "1a86", product: str = "7523", port: str | None = None) -> None:
    interface = root / name / f"{name}:1.0"
    interface.mkdir(parents=True)
    (root / name / "idVendor").write_text(f"{vendor}\n")
    (root / name / "idProduct").write_text(f"{product}\n")
    if port is not None:
        (interface / port).mkdir()


def test_a_ch340_whose_port_a_braille_driver_took_is_named_with_the_remedy(tmp_path: Path):
    usb_device(tmp_path, "1-2")
    check = look_for_ports(tmp_path)

    assert check.good is False
    assert "brltty, a driver of Braille displays, takes it" in check.text
    assert "sudo apt-get remove brltty" in check.text


@pytest.mark.parametrize("device", [{"port": "ttyUSB0"}, {"vendor": "2341", "product": "0043"}])
def test_a_ch340_with_its_port_and_another_chip_are_no_case_of_it(tmp_path: Path, device: dict[str, str]):
    usb_device(tmp_path, "1-2", **device)

    assert "brltty" not in look_for_ports(tmp_path).text


def test_disk_names_its_free_space(tmp_path: Path):
    assert "GB free" in check_disk(tmp_path).text
