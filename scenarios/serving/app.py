"""A bench over HTTP: the application. `openapi.json` documents it; every path but the page's wants the token."""

from __future__ import annotations

import asyncio
import re
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from importlib.metadata import version
from pathlib import Path
from typing import Annotated
from urllib.parse import quote

from fastapi import FastAPI, Query, Request
from fastapi.responses import HTMLResponse, JSONResponse, RedirectResponse, Response
from fastapi.staticfiles import StaticFiles
from starlette.types import Scope

from armtwin.models.errors import ArmtwinError, InputError
from armtwin.scenarios.serving.access import COOKIE, Guard
from armtwin.scenarios.serving.bench_routes import add_bench
from armtwin.scenarios.serving.job_routes import add_jobs
from armtwin.scenarios.serving.lease import LeaseError
from armtwin.scenarios.serving.picture_routes import add_pictures
from armtwin.scenarios.serving.visit import BusyError, Visit

PAGE = Path(__file__).parent / "page"
_TOKEN = re.compile(r"[\x21-\x7e]{1,200}")


def build_app(visit: Visit, token: str, hosts: tuple[str, ...] | None) -> FastAPI:
    """Return the application that serves a visit; `hosts` are the names it answers to, None any."""

    @asynccontextmanager
    async def lifespan(_: FastAPI) -> AsyncIterator[None]:
        yield
        await asyncio.to_thread(visit.close)

    app = FastAPI(
        title="armtwin bench",
        version=version("armtwin"),
        docs_url=None,
        redoc_url=None,
        lifespan=lifespan,
    )
    app.add_middleware(Guard, token=token, hosts=hosts)
    tell_errors(app)
    app.mount("/static", page_files(), name="static")
    add_entrance(app, lambda: (PAGE / "index.html").read_text("utf-8"))
    add_bench(app, visit)
    add_pictures(app, visit)
    add_jobs(app, visit)
    return app


def page_files() -> StaticFiles:
    """Return the page's files, asked for again by a page that loads itself again: a new server has new ones."""
    return _Fresh(directory=PAGE)


class _Fresh(StaticFiles):
    async def get_response(self, path: str, scope: Scope) -> Response:
        answer = await super().get_response(path, scope)
        answer.headers["Cache-Control"] = "no-cache"
        return answer


def tell_errors(app: FastAPI) -> None:
    """Answer a user's mistake, or a bench that cannot, in one line."""
    app.add_exception_handler(ArmtwinError, _told)


def add_entrance(app: FastAPI, page: Callable[[], str]) -> None:
    """Add the front page and the route that says that a server is here."""

    @app.get("/", response_class=HTMLResponse, include_in_schema=False)
    def index(request: Request, given: Annotated[str | None, Query(alias="token", max_length=200)] = None) -> Response:
        """Show the page; the link with the token leaves it in a cookie and out of the address."""
        if given is None:
            return HTMLResponse(page())
        answer = RedirectResponse("./", status_code=303)
        if not _TOKEN.fullmatch(given):  # none of ours; it would be the browser that it confuses
            return answer
        # A cookie of this place alone: two links of one server may be open in one browser.
        path, secure = quote(f"{request.scope.get('root_path', '')}/"), request.url.scheme == "https"
        answer.set_cookie(COOKIE, given, path=path, httponly=True, samesite="strict", secure=secure)
        return answer

    @app.get("/health")
    def health() -> dict[str, str]:
        """Say that a server is here, and which."""
        return {"armtwin": version("armtwin")}


async def _told(_: Request, error: Exception) -> Response:
    status = 409 if isinstance(error, LeaseError) else 429 if isinstance(error, BusyError) else 422
    if not isinstance(error, (InputError, LeaseError, BusyError)):
        status = 503
    return JSONResponse({"detail": str(error)}, status)
