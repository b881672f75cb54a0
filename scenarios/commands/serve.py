"""`armtwin serve`: a bench over HTTP, with a page for people."""

from __future__ import annotations

import importlib.util
import os
import socket
import threading
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console

from armtwin.models.errors import InputError, JobError
from armtwin.models.folder_lock import only_writer
from armtwin.scenarios.commands.interrupts import ended_as_by_ctrl_c
from armtwin.scenarios.commands.outputs import check_out_folder

if TYPE_CHECKING:
    from starlette.types import ASGIApp

LOOPBACK = "127.0.0.1"


def serve_command(
    bench: Annotated[
        str,
        typer.Option("--bench", help="'simulated', a scenario, 'emulated', or a bench file (TOML)."),
    ] = "simulated",
    course: Annotated[
        Path | None, typer.Option("--class", help="A class's folder, made by `armtwin lab make`, in place of a bench.")
    ] = None,
    check: Annotated[
        str | None, typer.Option("--check", help="Serve nothing: say what is between here and a server's address.")
    ] = None,
    host: Annotated[str, typer.Option("--host", help="Address to listen on; not loopback: opens it.")] = LOOPBACK,
    port: Annotated[int, typer.Option("--port", min=0, max=65535, help="0 takes a free one.")] = 8000,
    token: Annotated[
        str | None,
        typer.Option("--token", envvar="ARMTWIN_TOKEN", help="What visitors have to know."),
    ] = None,
    out: Annotated[Path, typer.Option("--out", help="Folder for recordings and reports.")] = Path("out/served"),
    root_path: Annotated[str, typer.Option("--root-path", help="Sub-path under which a reverse proxy shows it.")] = "",
    name: Annotated[
        list[str] | None, typer.Option("--name", help="Host name under which a reverse proxy shows it; repeatable.")
    ] = None,
) -> None:
    """Serve a bench: a page that moves the arm and shows camera and twin, and an address that programs move it by.

    Listens on this machine alone unless --host says otherwise. Whoever has the token may look; one at a time may move,
    within the bench's joint limits, and an arm whose mover falls silent for 15 s is detached. What is recorded is on
    disk below --out pose by pose. Programs reach it by: armtwin capture --bench http://127.0.0.1:8000/ --token TOKEN

    With --class every student's sealed robot is served, each by its own link, with a page for the instructor. With
    --check ADDRESS nothing is served: it says step by step what is between this machine and a server.

    Example: armtwin serve --bench simulated --port 8000
    """
    if any(importlib.util.find_spec(needed) is None for needed in ("fastapi", "uvicorn", "httpx")):
        raise InputError("serve: FastAPI, uvicorn or httpx is not installed; install armtwin[serve]")
    from armtwin.scenarios.serving.access import LOOPBACK as OWN_NAMES
    from armtwin.scenarios.serving.access import Under

    if check is not None:
        _tell_steps(check, token)
        return
    if token is not None and len(token) < 8:
        raise InputError("--token: at least 8 characters are wanted")
    screen = Console(stderr=True, highlight=False, soft_wrap=True)
    open_to_all = host not in OWN_NAMES
    hosts = None if open_to_all else (*OWN_NAMES, *(name or ()))
    folder = out if course is None else course
    check_out_folder(folder)
    if course is None:
        out.mkdir(parents=True, exist_ok=True)
    elif not course.is_dir():
        raise InputError(f"--class: {course}: no such folder; make it with armtwin lab make CLASS.toml --out {course}")
    listening = _listen(host, port)
    shown = LOOPBACK if host in ("0.0.0.0", "::") else host  # noqa: S104  # compared, not bound
    address = f"http://{shown}:{listening.getsockname()[1]}{root_path.rstrip('/')}/"
    with only_writer(folder), ended_as_by_ctrl_c():
        app, lines = _bench(bench, out, token, hosts) if course is None else _class(course, hosts)
        if open_to_all:
            screen.print(f"armtwin: WARNING: open to the network on {host}; whoever has the token moves the arm")
        for line in lines:
            screen.print(f"armtwin: {line.replace('ADDRESS', address)}", markup=False)
        _run(Under(app, root_path), listening)


def _bench(bench: str, out: Path, token: str | None, hosts: tuple[str, ...] | None) -> tuple[ASGIApp, list[str]]:
    from armtwin.scenarios.serving.access import new_token
    from armtwin.scenarios.serving.app import build_app
    from armtwin.scenarios.serving.sources import source_of
    from armtwin.scenarios.serving.visit import Visit

    visit, secret = Visit(source_of(bench), out), token or new_token()
    told = [f"{visit.source.title}, served at ADDRESS?token={secret}", f"recordings and reports in {out}; Ctrl-C ends"]
    return build_app(visit, secret, hosts), told


def _class(folder: Path, hosts: tuple[str, ...] | None) -> tuple[ASGIApp, list[str]]:
    from armtwin.scenarios.classes.class_app import ClassApp
    from armtwin.scenarios.classes.course import open_course
    from armtwin.scenarios.classes.draw import token

    course = open_course(folder)
    app = ClassApp(course, hosts)
    threading.Thread(target=app.prepare, name="prepare", daemon=True).start()
    return app, [
        f"{course.group.title}: {len(course.group.students)} students; their links are in {folder / 'links.csv'}",
        f"the instructor's page is ADDRESSinstructor/?token={token(course.group, '')}",
        f"what is measured and handed in is kept in {folder}; Ctrl-C ends",
    ]


def _run(app: ASGIApp, listening: socket.socket) -> None:
    import uvicorn

    config = uvicorn.Config(app, log_level="warning", access_log=False, timeout_graceful_shutdown=2)
    uvicorn.Server(config).run(sockets=[listening])


def _tell_steps(address: str, token: str | None) -> None:
    from armtwin.scenarios.serving.check_server import check_server

    failed = None
    for step in check_server(address, token):
        mark = {True: "ok  ", None: "look", False: "FAIL"}[step.works]
        typer.echo(f"{mark}  {step.name}: {step.said}")
        failed = step if step.works is False else None
    if failed is not None:
        raise JobError(f"{address.split('?')[0]}: stopped at the {failed.name}")


def _listen(host: str, port: int) -> socket.socket:
    """Bind first, so that a port that is taken is told before a bench is opened."""
    try:
        family, _, _, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
        # asyncio switches Nagle's waiting off (40 ms an answer) only where the protocol is stated.
        listening = socket.socket(family, socket.SOCK_STREAM, socket.IPPROTO_TCP)
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listening.bind(address)
        listening.listen()  # who is quicker than the bench waits instead of being turned away
    except socket.gaierror:
        raise InputError(f"--host: '{host}' is no address of this machine") from None
    except OSError as error:
        raise InputError(f"--port: {host}:{port} cannot be had: {os.strerror(error.errno or 0)}") from None
    return listening
