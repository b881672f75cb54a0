"""Pictures as MJPEG over HTTP on loopback, as network cameras send them: multipart/x-mixed-replace, newest first."""

from __future__ import annotations

import contextlib
import socket
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import cv2
import numpy as np
from numpy.typing import NDArray

_BOUNDARY = "armtwin"
PATH = "/stream.mjpg"
# Less than a picture waits on the way out.
_SEND_BUFFER_BYTES = 1 << 17
# Without chroma subsampling, and nearly without loss: what is tested is the arm, not a codec.
_JPEG = [
    *(cv2.IMWRITE_JPEG_QUALITY, 98),
    *(cv2.IMWRITE_JPEG_SAMPLING_FACTOR, cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444),
]


def to_jpeg(image: NDArray[np.uint8]) -> bytes:
    """Compress an (H, W, 3) BGR picture."""
    good, data = cv2.imencode(".jpg", image, _JPEG)
    if not good:
        raise ValueError(f"no picture: shape {image.shape}, {image.dtype}")
    return data.tobytes()


class MjpegServer:
    """Serves what was published last to everyone who asks, on 127.0.0.1 and a port of the system's choice.

    A client that is slower than the pictures misses some; a client that is faster gets each once.
    """

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._jpeg = b""
        self._number = 0
        self._open = True
        self._session = 0
        self._http = ThreadingHTTPServer(("127.0.0.1", 0), _handler_for(self))
        self._http.daemon_threads = True
        self._thread = threading.Thread(target=self._http.serve_forever, args=(0.05,), name="mjpeg", daemon=True)
        self._thread.start()

    @property
    def url(self) -> str:
        """Where the stream is."""
        return f"http://127.0.0.1:{self._http.server_port}{PATH}"

    def publish(self, jpeg: bytes) -> None:
        """Send this picture to every client."""
        with self._changed:
            self._jpeg = jpeg
            self._number += 1
            self._changed.notify_all()

    def drop_clients(self) -> None:
        """Break every connection off; new ones are served."""
        with self._changed:
            self._session += 1
            self._changed.notify_all()

    def close(self) -> None:
        """Break every connection off and free the port. May be called twice."""
        with self._changed:
            self._open = False
            self._changed.notify_all()
        self._http.shutdown()
        self._http.server_close()
        self._thread.join()

    def next_jpeg(self, number: int, session: int) -> tuple[bytes, int] | None:
        """Wait for a picture newer than `number`; None when the connection of `session` is to end."""
        with self._changed:
            self._changed.wait_for(lambda: self._number > number or not self._open or session != self._session)
            if not self._open or session != self._session:
                return None
            return self._jpeg, self._number

    @property
    def session(self) -> int:
        """Changes when the clients are dropped."""
        with self._changed:
            return self._session

    def __enter__(self) -> MjpegServer:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _handler_for(server: MjpegServer) -> type[BaseHTTPRequestHandler]:
    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            if self.path != PATH:
                self.send_error(404)
                return
            self.send_response(200)
            self.send_header("Content-Type", f"multipart/x-mixed-replace; boundary={_BOUNDARY}")
            self.send_header("Cache-Control", "no-store")
            self.end_headers()
            # A client that is slow for a moment must not be sent the pictures of that moment afterwards.
            self.connection.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _SEND_BUFFER_BYTES)
            session, number = server.session, 0
            with contextlib.suppress(ConnectionError):  # the client left
                while (item := server.next_jpeg(number, session)) is not None:
                    jpeg, number = item
                    head = f"--{_BOUNDARY}\r\nContent-Type: image/jpeg\r\nContent-Length: {len(jpeg)}\r\n\r\n"
                    self.wfile.write(head.encode("ascii") + jpeg + b"\r\n")

        def log_message(self, format: str, *args: object) -> None:  # noqa: A002 (the base class's name)
            """Keep quiet: a line a request on the user's terminal says nothing to him."""

    return Handler
