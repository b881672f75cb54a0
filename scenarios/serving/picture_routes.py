"""Routes of the pictures: taken, looked at, streamed, and what twin and detector say of them."""

from __future__ import annotations

import asyncio
import time
from collections.abc import AsyncIterator
from typing import Annotated

from fastapi import FastAPI, Query, Request
from fastapi.responses import JSONResponse, Response, StreamingResponse

from armtwin.scenarios.serving.on_bench import Lease, on_bench
from armtwin.scenarios.serving.shot import Miss, Shot
from armtwin.scenarios.serving.visit import Visit
from armtwin.scenarios.serving.wire import CaptureRequest, ShotInfo

# How long a picture is waited for before the page asks again.
_LONG_POLL_S = 5.0
_LOOK_S = 0.01


def add_pictures(app: FastAPI, visit: Visit) -> None:
    """Add them to an application."""
    live = visit.live

    @app.post("/api/capture")
    async def capture(wanted: CaptureRequest, lease: Lease = None) -> Response:
        """Take a picture; the answer is the PNG, X-Time-S when it was taken, X-Commanded-S when its pose
        was commanded, X-Picture its number."""
        visit.lease.check(lease)
        visit.check_idle()
        shot = await on_bench(visit, lambda: live.capture(wanted.keep))
        png = await asyncio.to_thread(lambda: shot.png)
        return Response(png, media_type="image/png", headers=_headers(shot))

    @app.post("/api/look")
    async def look(wanted: CaptureRequest, lease: Lease = None) -> ShotInfo:
        """Take a picture as `capture` does; the answer is what it shows, `picture.jpg` the picture itself."""
        visit.lease.check(lease)
        visit.check_idle()
        return _shot(visit, await on_bench(visit, lambda: live.capture(wanted.keep)))

    @app.get("/api/shot")
    async def shot(after: Annotated[int, Query(ge=0)] = 0) -> Response:
        """Say what the newest picture shows, as soon as there is one with a number above `after` (204: none came)."""
        newest = await _newer(visit, after)
        return Response(status_code=204) if newest is None else JSONResponse(_shot(visit, newest).model_dump())

    @app.get("/api/misses")
    def misses(after: Annotated[int, Query(ge=0)] = 0) -> list[Miss]:
        """Say how far the recorded poses from number `after` on were off when they were taken."""
        return live.misses[after:]

    @app.get("/api/picture.jpg")
    async def picture(number: Annotated[int, Query(ge=0)] = 0) -> Response:
        """Return the newest picture; `number` only makes the address differ."""
        if live.shot is None:
            return Response(status_code=204)
        newest = live.shot
        jpeg = await asyncio.to_thread(lambda: newest.jpeg)
        return Response(jpeg, media_type="image/jpeg", headers={"Cache-Control": "no-store", **_headers(newest)})

    @app.get("/api/stream.mjpeg")
    async def stream(request: Request) -> StreamingResponse:
        """Send every new picture as it comes."""

        async def parts() -> AsyncIterator[bytes]:
            after = 0
            while not await request.is_disconnected():
                newest = await _newer(visit, after)
                if newest is not None:
                    after, jpeg = newest.number, newest.jpeg
                    yield (
                        b"--frame\r\nContent-Type: image/jpeg\r\nContent-Length: %d\r\n\r\n" % len(jpeg)
                        + jpeg
                        + b"\r\n"
                    )

        return StreamingResponse(parts(), media_type="multipart/x-mixed-replace; boundary=frame")


async def _newer(visit: Visit, after: int) -> Shot | None:
    until = time.monotonic() + _LONG_POLL_S
    while time.monotonic() < until:
        shot = visit.live.shot
        if shot is not None and shot.number > after:
            return shot
        await asyncio.sleep(_LOOK_S)
    return None


def _headers(shot: Shot) -> dict[str, str]:
    given = shot.frame.commanded_s
    commanded = {} if given is None else {"X-Commanded-S": repr(float(given))}
    return {"X-Picture": str(shot.number), "X-Time-S": repr(float(shot.frame.time_s)), **commanded}


def _shot(visit: Visit, shot: Shot) -> ShotInfo:
    what = visit.source.description
    return ShotInfo(
        number=shot.number,
        time_s=float(shot.frame.time_s),
        q_cmd_rad=shot.q_cmd.tolist(),
        poses=visit.live.poses,
        measured_px={name: px.tolist() for name, px in shot.measured_px.items()},
        twin_px={name: px.tolist() for name, px in shot.twin_px.items()},
        miss_mm={name: mm.tolist() for name, mm in shot.misses_mm(what.camera, what.arm_plane_z_mm).items()},
        twin_bodies={name: T.tolist() for name, T in shot.twin_bodies.items()},
        true_bodies={name: T.tolist() for name, T in shot.true_bodies.items()},
    )
