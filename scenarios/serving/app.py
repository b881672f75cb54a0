"""The routes: a bench over HTTP. `openapi.json` documents them; every path but the page's wants the token."""

from __future__ import annotations

import asyncio
import io
import time
import zipfile
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from importlib.metadata import version
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from fastapi import FastAPI, Header, Query, Request
from fastapi.responses import FileResponse, HTMLResponse, JSONResponse, RedirectResponse, Response, StreamingResponse
from fastapi.staticfiles import StaticFiles

from armtwin.models.catalogue.registry import catalogue
from armtwin.models.errors import ArmtwinError, InputError
from armtwin.models.recordings.writer import arm_table, camera_table
from armtwin.scenarios.scenario import EffectTable
from armtwin.scenarios.serving.access import COOKIE, Guard
from armtwin.scenarios.serving.faults import checked_fault, declaration
from armtwin.scenarios.serving.lease import LeaseError
from armtwin.scenarios.serving.shot import Miss, Shot
from armtwin.scenarios.serving.visit import BusyError, Visit
from armtwin.scenarios.serving.wire import (
    BenchInfo,
    CaptureRequest,
    Connected,
    Fault,
    FaultsRequest,
    HangRequest,
    JobInfo,
    JobRequest,
    JointInfo,
    MoveRequest,
    PlanRequest,
    ShotInfo,
    State,
)

PAGE = Path(__file__).parent / "page"
# How long a picture is waited for before the page asks again.
_LONG_POLL_S = 5.0
_LOOK_S = 0.01
# What a job may be asked for.
_RESULTS = ("report.html", "diagnosis.json", "twin.toml", "next_experiment.csv")

Lease = Annotated[str | None, Header(alias="X-Lease")]


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
    app.mount("/static", StaticFiles(directory=PAGE), name="static")
    add_entrance(app, lambda: (PAGE / "index.html").read_text("utf-8"))
    _add_bench(app, visit)
    _add_pictures(app, visit)
    _add_jobs(app, visit)
    return app


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
        # A cookie of this place alone: two links of one server may be open in one browser.
        path, secure = f"{request.scope.get('root_path', '')}/", request.url.scheme == "https"
        answer.set_cookie(COOKIE, given, path=path, httponly=True, samesite="strict", secure=secure)
        return answer

    @app.get("/health")
    def health() -> dict[str, str]:
        """Say that a server is here, and which."""
        return {"armtwin": version("armtwin")}


def _add_bench(app: FastAPI, visit: Visit) -> None:
    live, source, what = visit.live, visit.source, visit.source.description

    @app.get("/api/bench")
    def bench() -> BenchInfo:
        """Say what is served."""
        limits = what.limits
        pairs = zip(limits.min_rad.tolist(), limits.max_rad.tolist(), strict=True)
        header = {
            "arm": arm_table(what.arm),
            "camera": camera_table(what.camera),
            "arm_plane_z_mm": what.arm_plane_z_mm,
        }
        return BenchInfo(
            kind=what.kind,
            title=source.title,
            version=version("armtwin"),
            arm=arm_table(what.arm),
            joints=[JointInfo(min_rad=low, max_rad=high) for low, high in pairs],
            max_step_rad=float(limits.max_step_rad),
            image_width=what.camera.image_width,
            image_height=what.camera.image_height,
            marker_names=list(what.arm.marker_names),
            link_lengths_mm=what.arm.link_lengths_mm.tolist(),
            start_rad=next(iter(source.plans.values())).q_cmd[0].tolist(),
            plans={name: len(plan) for name, plan in source.plans.items()},
            takes_faults=source.takes_faults,
            hangs_loads=what.hangs_loads,
            actuation=dict(what.actuation),
            recording_header=header,
            tools=list(source.terms.tools) if source.terms is not None else ["calibrate", "diagnose"],
        )

    @app.get("/api/state")
    def state(lease: Lease = None) -> State:
        """Say how things stand; who holds the arm is heard by it."""
        return State(
            version=version("armtwin"),
            connected=live.connected,
            yours=visit.lease.hear(lease),
            held=visit.lease.held,
            q_cmd_rad=None if live.q_cmd is None else live.q_cmd.tolist(),
            picture=0 if live.shot is None else live.shot.number,
            poses=live.poses,
            twin=live.twin.name,
            faults=[Fault(**fault.model_dump()) for fault in live.faults],
            running=visit.running,
            progress=visit.progress,
            said=visit.said,
            jobs=[_job(job) for job in visit.jobs.all()],
            pictures_left=live.pictures_left,
        )

    @app.post("/api/lease")
    def take() -> dict[str, str]:
        """Take the arm; the key goes into the header X-Lease of every call that moves."""
        return {"lease": visit.lease.take()}

    @app.delete("/api/lease")
    async def give_back(lease: Lease = None) -> dict[str, bool]:
        """Give the arm back; it is detached."""
        visit.lease.check(lease)
        visit.stop_plan()
        await _on_bench(visit, live.close)
        visit.lease.end()
        return {"given_back": True}

    @app.post("/api/connect")
    async def connect(lease: Lease = None) -> Connected:
        """Open the bench anew, the arm as it stands when it is switched on."""
        visit.lease.check(lease)
        visit.check_idle()
        await _on_bench(visit, live.connect)
        return Connected(notes=list(live.notes), clock_origin_s=live.clock_origin_s)

    @app.post("/api/move")
    async def move(wanted: MoveRequest, lease: Lease = None) -> dict[str, list[float]]:
        """Go to joint angles and answer when the arm rests."""
        visit.lease.check(lease)
        visit.check_idle()
        q = np.array(wanted.q_cmd_rad)
        await _on_bench(visit, lambda: live.approach(q) if wanted.approach else live.move(q))
        return {"q_cmd_rad": wanted.q_cmd_rad}

    @app.post("/api/hang")
    async def hang(wanted: HangRequest, lease: Lease = None) -> dict[str, float]:
        """Hang a mass at the tip of a bench that can."""
        visit.lease.check(lease)
        visit.check_idle()
        await _on_bench(visit, lambda: live.hang(wanted.payload_kg))
        return {"payload_kg": wanted.payload_kg}

    @app.get("/api/effects")
    def effects() -> list[dict[str, Any]]:
        """List the faults that can be put into a simulated bench, with parameters, units and bounds."""
        return [declaration(effect, what.arm) for effect in catalogue().values()] if source.takes_faults else []

    @app.put("/api/faults")
    async def faults(wanted: FaultsRequest, lease: Lease = None) -> dict[str, int]:
        """Put these faults into the bench instead of those that are in it."""
        visit.lease.check(lease)
        chosen = [
            checked_fault(EffectTable(**fault.model_dump()), number, what.arm)
            for number, fault in enumerate(wanted.faults)
        ]
        await asyncio.to_thread(visit.put_faults, chosen)
        return {"faults": len(chosen)}

    @app.post("/api/plan")
    def plan(wanted: PlanRequest, lease: Lease = None) -> dict[str, str]:
        """Run a plan and keep its poses."""
        visit.lease.check(lease)
        visit.start_plan(wanted.name, wanted.job)
        return {"running": visit.running or ""}

    @app.delete("/api/plan")
    def stop(lease: Lease = None) -> dict[str, bool]:
        """Stop the plan that runs."""
        visit.lease.check(lease)
        visit.stop_plan()
        return {"stopping": True}


def _add_pictures(app: FastAPI, visit: Visit) -> None:
    live = visit.live

    @app.post("/api/capture")
    async def capture(wanted: CaptureRequest, lease: Lease = None) -> Response:
        """Take a picture; the answer is the PNG, X-Time-S when it was taken, X-Commanded-S when its pose
        was commanded, X-Picture its number."""
        visit.lease.check(lease)
        visit.check_idle()
        shot = await _on_bench(visit, lambda: live.capture(wanted.keep))
        png = await asyncio.to_thread(lambda: shot.png)
        return Response(png, media_type="image/png", headers=_headers(shot))

    @app.post("/api/look")
    async def look(wanted: CaptureRequest, lease: Lease = None) -> ShotInfo:
        """Take a picture as `capture` does; the answer is what it shows, `picture.jpg` the picture itself."""
        visit.lease.check(lease)
        visit.check_idle()
        return _shot(visit, await _on_bench(visit, lambda: live.capture(wanted.keep)))

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


def _add_jobs(app: FastAPI, visit: Visit) -> None:
    live = visit.live

    @app.post("/api/recording")
    async def begin(lease: Lease = None) -> dict[str, bool]:
        """Begin an empty recording; the last one stays on the server's disk."""
        visit.lease.check(lease)
        visit.check_idle()
        await _on_bench(visit, live.begin_recording)
        return {"empty": True}

    @app.get("/api/recording.zip")
    async def download() -> Response:
        """Return the present recording, its pictures left out where it would be large."""
        folder = await asyncio.wrap_future(visit.submit(live.recording_folder))
        data = await asyncio.to_thread(_zipped, folder)
        name = f"{folder.name}.zip"
        return Response(
            data, media_type="application/zip", headers={"Content-Disposition": f'attachment; filename="{name}"'}
        )

    @app.post("/api/jobs")
    async def start(wanted: JobRequest) -> JobInfo:
        """Calibrate or diagnose what is recorded, beside the bench."""
        return _job(await asyncio.to_thread(visit.diagnose, wanted.kind))

    @app.delete("/api/jobs/{number}")
    def stop(number: int) -> JobInfo:
        """Stop a job."""
        visit.jobs.stop(number)
        return _job(visit.jobs.get(number))

    @app.get("/api/jobs/{number}/{name}")
    def result(number: int, name: str) -> FileResponse:
        """Return a file that a job wrote."""
        job = visit.jobs.get(number)
        if name not in _RESULTS or name not in job.results:
            raise InputError(f"job {number} wrote no such file; it wrote {', '.join(job.results) or 'none yet'}")
        return FileResponse(job.folder / name)


async def _on_bench(visit: Visit, call: Callable[[], Any]) -> Any:
    with visit.lease.at_work():
        return await asyncio.wrap_future(visit.submit(call))


async def _newer(visit: Visit, after: int) -> Shot | None:
    until = time.monotonic() + _LONG_POLL_S
    while time.monotonic() < until:
        shot = visit.live.shot
        if shot is not None and shot.number > after:
            return shot
        await asyncio.sleep(_LOOK_S)
    return None


async def _told(_: Request, error: Exception) -> Response:
    status = 409 if isinstance(error, LeaseError) else 429 if isinstance(error, BusyError) else 422
    if not isinstance(error, (InputError, LeaseError, BusyError)):
        status = 503
    return JSONResponse({"detail": str(error)}, status)


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


def _job(job: Any) -> JobInfo:
    seconds = job.seconds or time.monotonic() - job.started_s
    return JobInfo(
        number=job.number,
        kind=job.kind,
        state=job.state,
        said=job.said,
        headline=job.headline,
        seconds=seconds,
        results=[name for name in _RESULTS if name in job.results],
    )


def _zipped(folder: Path) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in ("recording.json", "samples.csv"):
            archive.write(folder / name, f"{folder.name}/{name}")
    return out.getvalue()
