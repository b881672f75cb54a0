"""What stands at an address in place of a stream, each told apart, by a real server on loopback."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import numpy as np
import pytest

from armtwin.hardware.bench.tables import CameraSettings
from armtwin.hardware.camera.stream_faults import what_it_gives
from armtwin.hardware.camera.webcam import Webcam
from armtwin.hardware.emulator.mjpeg import to_jpeg
from armtwin.models.errors import InputError

JPEG = to_jpeg(np.zeros((360, 640, 3), np.uint8))
PART = b"Content-Type: image/jpeg\r\nContent-Length: %d\r\n\r\n" % len(JPEG) + JPEG + b"\r\n"
MIXED = "multipart/x-mixed-replace; boundary=b"
# Path: status, content type, body.
PAGES: dict[str, tuple[int, str, bytes]] = {
    "/locked": (401, "text/plain", b""),
    "/failing": (500, "text/plain", b""),
    "/page": (200, "text/html", b"<html><body>My camera</body></html>"),
    "/shot": (200, "image/jpeg", JPEG),
    "/no-first": (200, MIXED, PART + (b"--b\r\n" + PART) * 20),
    "/no-boundary": (200, "multipart/x-mixed-replace", (b"--b\r\n" + PART) * 20),
    "/sound": (200, "audio/mpeg", b"ID3" + bytes(1000)),
    "/good": (200, MIXED, (b"--b\r\n" + PART) * 20),
}


class Handler(BaseHTTPRequestHandler):
    def do_GET(self) -> None:
        allowed = self.headers.get("Authorization") == "Basic bWU6cy9lY3JldA=="  # me:s/ecret
        status, kind, body = PAGES.get(self.path, (404, "text/plain", b""))
        status = 200 if allowed and status == 401 else status
        self.send_response(status)
        self.send_header("Content-Type", MIXED if allowed else kind)
        self.end_headers()
        with contextlib.suppress(ConnectionError):
            self.wfile.write(PAGES["/good"][2] if allowed else body)

    def log_message(self, format: str, *args: object) -> None:  # noqa: A002 (the base class's name)
        """Keep quiet."""


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    thread = threading.Thread(target=server.serve_forever, args=(0.05,), daemon=True)
    thread.start()
    yield f"127.0.0.1:{server.server_port}"
    server.shutdown()
    server.server_close()


@pytest.mark.parametrize(
    ("path", "message"),
    [
        ("/locked", r"it wants a name and a password \(401\); write http://NAME:PASSWORD@HOST/"),
        ("/nowhere", r"there is no such page on its server \(404\); the address of the stream is in"),
        ("/failing", r"its server refuses \(500\)"),
        ("/page", "it is a web page, no stream"),
        ("/shot", r"it is a single picture \(image/jpeg\), no stream"),
        ("/no-first", "MJPEG without the boundary --b before its first picture"),
        ("/no-boundary", "MJPEG whose header names no boundary"),
        ("/sound", "it sends audio/mpeg, an MJPEG stream"),
    ],
)
def test_a_camera_that_is_no_stream_is_refused_with_what_it_is(address: str, path: str, message: str) -> None:
    settings = CameraSettings(source=f"http://{address}{path}", calibration="camera.yaml", arm_plane_z_mm=0.0)
    with pytest.raises(InputError, match=message) as refused:
        Webcam(settings, 640, 360).open()
    assert "\n" not in str(refused.value)


def test_a_name_and_a_password_in_the_address_are_sent(address: str) -> None:
    assert what_it_gives(f"http://me:s%2Fecret@{address}/locked") is None


def test_nothing_at_all_is_told_from_a_wrong_page() -> None:
    found = what_it_gives("http://127.0.0.1:1/stream")
    assert found is not None
    assert found.startswith("nothing answers there (")
