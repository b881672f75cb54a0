"""What an address that gives no stream gives instead, asked over HTTP once the video reader has failed on it."""

from __future__ import annotations

import base64
import http.client
import re
import urllib.error
import urllib.request
from urllib.parse import unquote, urlsplit, urlunsplit

_TIMEOUT_S = 3.0
_LOOKED_AT_BYTES = 512
_WHERE = "the address of the stream is in the camera's or its app's manual (often /video, /stream or /mjpg/video.mjpg)"


def what_it_gives(url: str) -> str | None:
    """Return in words what stands at `url` in place of an MJPEG stream; None where it looks like one."""
    try:
        with urllib.request.urlopen(_request(url), timeout=_TIMEOUT_S) as answer:  # noqa: S310 (http and https alone)
            kind = answer.headers.get_content_type()
            boundary = answer.headers.get_param("boundary")
            start = answer.read1(_LOOKED_AT_BYTES) if hasattr(answer, "read1") else answer.read(_LOOKED_AT_BYTES)
    except urllib.error.HTTPError as error:
        return _of_status(error.code)
    except urllib.error.URLError as error:
        return f"nothing answers there ({_plain(error.reason)}); is its server running, and is the address right?"
    except (OSError, http.client.HTTPException, ValueError) as error:
        return f"it breaks off ({_plain(error)}); is it a web server?"
    return _of_content(kind, None if boundary is None else str(boundary), start)


def _request(url: str) -> urllib.request.Request:
    """Return the request, a name and a password in the address as the header that they stand for."""
    parts = urlsplit(url)
    host = parts.netloc.rpartition("@")[2]
    request = urllib.request.Request(urlunsplit(parts._replace(netloc=host)))  # noqa: S310 (as above)
    if parts.username is not None:
        both = f"{unquote(parts.username)}:{unquote(parts.password or '')}".encode()
        request.add_header("Authorization", f"Basic {base64.b64encode(both).decode('ascii')}")
    return request


def _of_status(status: int) -> str:
    if status in (401, 403):
        return f"it wants a name and a password ({status}); write http://NAME:PASSWORD@HOST/... in camera.source"
    if status == 404:
        return f"there is no such page on its server (404); {_WHERE}"
    return f"its server refuses ({status}); look at the camera's own page in a browser"


def _of_content(kind: str, boundary: str | None, start: bytes) -> str | None:
    if kind == "text/html" or start.lstrip()[:5].lower() in (b"<html", b"<!doc"):
        return f"it is a web page, no stream; {_WHERE}"
    if kind == "multipart/x-mixed-replace":
        return _of_parts(boundary, start)
    if kind.startswith("image/") or start[:3] == b"\xff\xd8\xff":
        return f"it is a single picture ({kind}), no stream; {_WHERE}"
    if not start:
        return "it answers and sends nothing; restart the stream"
    return f"it sends {kind}, an MJPEG stream (multipart/x-mixed-replace) is wanted"


def _of_parts(boundary: str | None, start: bytes) -> str | None:
    if boundary is None:
        return (
            "it is MJPEG whose header names no boundary, which cannot be read; serve it by mjpg-streamer or ustreamer"
        )
    lines = re.split(rb"\r?\n", start.lstrip())
    if not lines[0].startswith(b"--"):
        return (
            f"it is MJPEG without the boundary --{boundary.removeprefix('--')} before its first picture, which cannot "
            "be read; serve it by mjpg-streamer or ustreamer"
        )
    return None


def _plain(reason: object) -> str:
    text = getattr(reason, "strerror", None) or str(reason) or type(reason).__name__
    return " ".join(str(text).split())[:80]
