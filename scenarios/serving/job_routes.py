"""Routes of the recording and of the jobs on it."""

from __future__ import annotations

import asyncio
import io
import time
import zipfile
from pathlib import Path

from fastapi import FastAPI
from fastapi.responses import FileResponse, Response

from armtwin.models.errors import InputError
from armtwin.scenarios.serving.jobs import Job
from armtwin.scenarios.serving.on_bench import Lease, on_bench
from armtwin.scenarios.serving.visit import Visit
from armtwin.scenarios.serving.wire import JobInfo, JobRequest

# What a job may be asked for.
_RESULTS = ("report.html", "diagnosis.json", "twin.toml", "next_experiment.csv")


def add_jobs(app: FastAPI, visit: Visit) -> None:
    """Add them to an application."""
    live = visit.live

    @app.post("/api/recording")
    async def begin(lease: Lease = None) -> dict[str, bool]:
        """Begin an empty recording; the last one stays on the server's disk."""
        visit.lease.check(lease)
        visit.check_idle()
        await on_bench(visit, live.begin_recording)
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
        return job_info(await asyncio.to_thread(visit.diagnose, wanted.kind))

    @app.delete("/api/jobs/{number}")
    def stop(number: int) -> JobInfo:
        """Stop a job."""
        visit.jobs.stop(number)
        return job_info(visit.jobs.get(number))

    @app.get("/api/jobs/{number}/{name}")
    def result(number: int, name: str) -> FileResponse:
        """Return a file that a job wrote."""
        job = visit.jobs.get(number)
        if name not in _RESULTS or name not in job.results:
            raise InputError(f"job {number} wrote no such file; it wrote {', '.join(job.results) or 'none yet'}")
        return FileResponse(job.folder / name)


def job_info(job: Job) -> JobInfo:
    """Return a job as it goes over the wire."""
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
