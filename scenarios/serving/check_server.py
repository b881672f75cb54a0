"""What is between this machine and a server: each step from the name to an answer; what fails comes with a remedy."""

from __future__ import annotations

import os
import socket
import time
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.metadata import version
from urllib.parse import parse_qs, urlsplit

import httpx

from armtwin.models.errors import InputError

_WAIT_S = 10.0
_SLOW_S = 1.0
_PROXIES = ("http_proxy", "https_proxy", "all_proxy")


@dataclass(frozen=True)
class Step:
    """A step: what was tried, whether it works (None: works, but look), and what was found or is to be done."""

    name: str
    works: bool | None
    said: str


def check_server(address: str, token: str | None = None) -> Iterator[Step]:
    """Yield the steps to a server's address until one fails; the link with its token will do for `address`.

    Raises `InputError` for what is no address.
    """
    try:
        parts = urlsplit(address)
        host, port = parts.hostname, parts.port or {"http": 80, "https": 443}.get(parts.scheme)
    except ValueError:
        host = port = None
    if not host or port is None:
        raise InputError(f"--check: '{address[:80]}' is no address; http://HOST:PORT/ is wanted")
    token = token or next(iter(parse_qs(parts.query).get("token", [])), None)
    base = f"{parts.scheme}://{parts.netloc}{parts.path.rstrip('/')}"
    for step in _steps(base, host, port, token):
        yield step
        if step.works is False:
            return


def _steps(base: str, host: str, port: int, token: str | None) -> Iterator[Step]:
    try:
        found = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)
    except (socket.gaierror, UnicodeError):
        yield Step(
            "name", False, f"nobody knows '{host}'; is it spelt right, and are you in the network that knows it?"
        )
        return
    yield Step("name", True, f"{host} is {found[0][4][0]}")
    try:
        socket.create_connection((host, port), _WAIT_S).close()
    except OSError as error:
        why = "nothing listens there" if isinstance(error, ConnectionRefusedError) else "no answer, a firewall perhaps"
        yield Step("port", False, f"{port}: {why}; is the server running with --host, and is the port let through?")
        return
    yield Step("port", True, f"{port} answers")
    proxies = [name for name in _PROXIES if os.environ.get(name) or os.environ.get(name.upper())]
    if proxies:
        yield Step("proxy", None, f"{', '.join(proxies)} is set: a browser may go by it; programs of armtwin do not")
    yield from _http(base, token)


def _http(base: str, token: str | None) -> Iterator[Step]:
    headers = {} if token is None else {"Authorization": f"Bearer {token}"}
    with httpx.Client(timeout=_WAIT_S, trust_env=False, headers=headers) as client:
        try:
            answer = client.get(f"{base}/health")
        except httpx.ConnectError as error:
            said = (
                "speaks no HTTPS, or with a certificate that this machine does not trust"
                if "SSL" in str(error)
                else error
            )
            yield Step("web", False, f"{said}; try http:// or ask who serves")
            return
        except httpx.HTTPError as error:
            yield Step("web", False, f"broke off ({type(error).__name__}); something between drops the connection")
            return
        theirs = _version_of(answer)
        if theirs is None:
            yield Step("web", False, f"answers {answer.status_code}, but is no armtwin; a proxy, or another path?")
            return
        yield Step("web", True, f"armtwin {theirs}")
        ours = version("armtwin")
        if theirs != ours:
            yield Step("version", None, f"this machine has armtwin {ours}; take the same one if programs disagree")
        if token is None:
            yield Step("token", None, "none was given: check the whole link, or add --token")
            return
        before = time.monotonic()
        answer = client.get(f"{base}/api/state")
        took = time.monotonic() - before
        if answer.status_code == httpx.codes.UNAUTHORIZED:
            yield Step("token", False, "it is wrong for this address; use the link as it was handed out")
            return
        if not answer.is_success:
            yield Step("bench", False, f"answers {answer.status_code} ({answer.text[:100]})")
            return
        yield Step("token", True, "it is the right one")
        slow = took > _SLOW_S
        yield Step(
            "speed", None if slow else True, f"{1000 * took:.0f} ms an answer{', slow but usable' if slow else ''}"
        )


def _version_of(answer: httpx.Response) -> str | None:
    try:
        found = answer.json()["armtwin"]
    except (ValueError, KeyError, TypeError):
        return None
    return str(found)[:40]
