import http.client
import threading
import urllib.error
import urllib.parse
import urllib.request

import cv2
import numpy as np
import pytest

from armtwin.hardware.emulator.mjpeg import MjpegServer, to_jpeg


def read_part(stream: http.client.HTTPResponse) -> bytes:
    """Read one picture of a multipart stream."""
    length = 0
    while (line := stream.readline().strip()) or not length:
        if line.lower().startswith(b"content-length:"):
            length = int(line.split(b":")[1])
    return stream.read(length)


@pytest.fixture
def server():
    with MjpegServer() as running:
        yield running


def test_listens_on_loopback_only(server: MjpegServer):
    assert urllib.parse.urlparse(server.url).hostname == "127.0.0.1"


def test_a_client_gets_what_was_published_last_and_then_what_follows(server: MjpegServer):
    server.publish(b"old")
    server.publish(b"new")
    with urllib.request.urlopen(server.url, timeout=5) as stream:
        first = read_part(stream)
        server.publish(b"next")
        second = read_part(stream)

    assert (first, second) == (b"new", b"next")


def test_two_clients_get_the_same_picture(server: MjpegServer):
    server.publish(b"picture")
    with urllib.request.urlopen(server.url, timeout=5) as a, urllib.request.urlopen(server.url, timeout=5) as b:
        assert read_part(a) == read_part(b) == b"picture"


def test_dropped_clients_reach_the_end_of_the_stream(server: MjpegServer):
    server.publish(b"picture")
    with urllib.request.urlopen(server.url, timeout=5) as stream:
        read_part(stream)
        server.drop_clients()
        assert stream.read() == b"\r\n"


def test_another_path_is_not_found(server: MjpegServer):
    with pytest.raises(urllib.error.HTTPError, match="404"):
        urllib.request.urlopen(server.url.replace("/stream", "/other"), timeout=5)


def test_close_ends_its_threads():
    before = threading.active_count()
    server = MjpegServer()
    server.close()
    assert threading.active_count() == before


def test_jpeg_keeps_a_red_disc_within_a_few_grey_levels():
    image = np.full((120, 160, 3), 40, np.uint8)
    cv2.circle(image, (80, 60), 30, (30, 30, 200), -1, cv2.LINE_AA)

    decoded = cv2.imdecode(np.frombuffer(to_jpeg(image), np.uint8), cv2.IMREAD_COLOR)

    assert np.abs(decoded.astype(int) - image).mean() < 1.0
