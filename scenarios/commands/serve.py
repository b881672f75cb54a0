"""`armtwin serve`: a bench over HTTP, with a page for people."""

from __future__ import annotations

import importlib.util
import os
import socket
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from armtwin.models.errors import InputError
from armtwin.models.folder_lock import only_writer
from armtwin.scenarios.commands.interrupts import ended_as_by_ctrl_c
from armtwin.scenarios.commands.outputs import check_out_folder

LOOPBACK = "127.0.0.1"


def serve_command(
    bench: Annotated[
        str,
        typer.Option("--bench", help="'simulated', a scenario, 'emulated', or a bench file (TOML)."),
    ] = "simulated",
    host: Annotated[str, typer.Option("--host", help="Address to listen on; not loopback: opens it.")] = LOOPBACK,
    port: Annotated[int, typer.Option("--port", min=0, max=65535, help="0 takes a free one.")] = 8000,
    token: Annotated[
        str | None,
        typer.Option("--token", envvar="ARMTWIN_TOKEN", help="What visitors have to know."),
    ] = None,
    out: Annotated[Path, typer.Option("--out", help="Folder for recordings and reports.")] = Path("out/served"),
    root_path: Annotated[str, typer.Option("--root-path", help="Sub-path under which a reverse proxy shows it.")] = "",
) -> None:
    """Serve a bench: a page that moves the arm and shows camera and twin, and an address that programs move it by.

    Listens on this machine alone unless --host says otherwise. Whoever has the token may look; one at a time may move,
    within the bench's joint limits, and an arm whose mover falls silent for 15 s is detached. What is recorded is on
    disk below --out pose by pose. Programs reach it by: armtwin capture --bench http://127.0.0.1:8000/ --token TOKEN

    Example: armtwin serve --bench simulated --port 8000
    """
    if importlib.util.find_spec("fastapi") is None or importlib.util.find_spec("uvicorn") is None:
        raise InputError("serve: FastAPI and uvicorn are not installed; install armtwin[serve]")
    import uvicorn

    from armtwin.scenarios.serving.access import LOOPBACK as OWN_NAMES
    from armtwin.scenarios.serving.access import new_token
    from armtwin.scenarios.serving.app import build_app
    from armtwin.scenarios.serving.sources import source_of
    from armtwin.scenarios.serving.visit import Visit

    if token is not None and len(token) < 8:
        raise InputError("--token: at least 8 characters are wanted")
    check_out_folder(out)
    out.mkdir(parents=True, exist_ok=True)
    listening = _listen(host, port)
    secret = token or new_token()
    screen = Console(stderr=True, highlight=False, soft_wrap=True)
    open_to_all = host not in OWN_NAMES
    with only_writer(out), ended_as_by_ctrl_c():
        visit = Visit(source_of(bench), out)
        app = build_app(visit, secret, None if open_to_all else OWN_NAMES, root_path)
        shown = LOOPBACK if host in ("0.0.0.0", "::") else host  # noqa: S104  # compared, not bound
        address = f"http://{shown}:{listening.getsockname()[1]}/"
        if open_to_all:
            screen.print(f"armtwin: WARNING: open to the network on {host}; whoever has the token moves the arm")
        screen.print(f"armtwin: {visit.source.title}, served at {address}?token={secret}")
        screen.print(f"armtwin: recordings and reports in {out}; Ctrl-C ends", markup=False)
        config = uvicorn.Config(app, log_level="warning", access_log=False, timeout_graceful_shutdown=2)
        uvicorn.Server(config).run(sockets=[listening])


def _listen(host: str, port: int) -> socket.socket:
    """Bind first, so that a port that is taken is told before a bench is opened."""
    try:
        family, _, _, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
        listening = socket.socket(family, socket.SOCK_STREAM)
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listening.bind(address)
        listening.listen()  # who is quicker than the bench waits instead of being turned away
    except socket.gaierror:
        raise InputError(f"--host: '{host}' is no address of this machine") from None
    except OSError as error:
        raise InputError(f"--port: {host}:{port} cannot be had: {os.strerror(error.errno or 0)}") from None
    return listening
