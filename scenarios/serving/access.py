"""Who may speak to a served bench: whoever knows its token, by a host name that is this machine's."""

from __future__ import annotations

import secrets
from collections.abc import Collection

from starlette.datastructures import Headers
from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

LOOPBACK = ("127.0.0.1", "localhost", "[::1]")
COOKIE = "armtwin_token"
# Nothing that a visitor sends is longer: a plan of 10,000 poses of six joints in 17 digits.
MOST_BODY_BYTES = 2 << 20
# The page itself and what it is drawn with give nothing away.
_OPEN_PATHS = ("/", "/static/", "/health")


class Guard:
    """ASGI middleware that refuses wrong tokens, foreign host names and bodies without measure.

    A page of another site that a visitor has open can neither read the token nor, behind another name for this machine
    (DNS rebinding), be let in by it.
    """

    def __init__(self, app: ASGIApp, token: str, hosts: Collection[str] | None) -> None:
        self._app = app
        self._token = token
        self._hosts = hosts  # None: whatever name the network has for this machine

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Let a request through, or answer it with what is wrong."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        refusal = self.refusal(scope)
        if refusal is not None:
            await refusal(scope, receive, send)
            return
        await self._app(scope, _bounded(receive), send)

    def refusal(self, scope: Scope) -> Response | None:
        """Return the answer to a request that is not let through, or None."""
        headers = Headers(scope=scope)
        host = (
            headers.get("host", "").rsplit(":", 1)[0] if not headers.get("host", "").endswith("]") else headers["host"]
        )
        if self._hosts is not None and host not in self._hosts:
            return _error(403, f"host '{host[:60]}' is not this bench's; open it as http://127.0.0.1")
        if int(headers.get("content-length", "0") or 0) > MOST_BODY_BYTES:
            return _error(413, f"larger than {MOST_BODY_BYTES} bytes")
        path = route_of(scope)
        if path in _OPEN_PATHS or path.startswith("/static/"):
            return None
        return (
            None if self.allows(Request(scope)) else _error(401, "the token is missing or wrong; the server printed it")
        )

    def allows(self, request: Request) -> bool:
        """Whether a request carries the token: as bearer, or as the cookie of the page."""
        scheme, _, bearer = request.headers.get("authorization", "").partition(" ")
        given = bearer if scheme.lower() == "bearer" else request.cookies.get(COOKIE, "")
        return secrets.compare_digest(given.encode(), self._token.encode())


class Under:
    """ASGI middleware for a server that a reverse proxy shows under a sub-path, whether the proxy strips it or not."""

    def __init__(self, app: ASGIApp, root_path: str) -> None:
        self._app = app
        self._root = root_path.rstrip("/")

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Let the request know where it is shown."""
        if scope["type"] == "http" and self._root:
            path = scope["path"]
            inside = path == self._root or path.startswith(f"{self._root}/")
            scope = {**scope, "root_path": self._root, "path": path if inside else self._root + path}
        await self._app(scope, receive, send)


def route_of(scope: Scope) -> str:
    """Return a request's path below the place where the application is shown."""
    path, root = str(scope["path"]), str(scope.get("root_path", ""))
    below = path.removeprefix(root) if path == root or path.startswith(f"{root}/") else path
    return below or "/"


def new_token() -> str:
    """Return a token that nobody guesses."""
    return secrets.token_urlsafe(18)


def _bounded(receive: Receive) -> Receive:
    """Count what arrives: a body that states no length is cut off at the bound too."""
    total = 0

    async def counted() -> Message:
        nonlocal total
        message = await receive()
        total += len(message.get("body", b""))
        return message if total <= MOST_BODY_BYTES else {"type": "http.disconnect"}

    return counted


def _error(status: int, detail: str) -> Response:
    return JSONResponse({"detail": detail}, status)
