"""Routes of the bench itself: what it is, how it stands, who moves it, what is put into it."""

from __future__ import annotations

import asyncio
from importlib.metadata import version
from typing import Any

import numpy as np
from fastapi import FastAPI

from armtwin.models.catalogue.registry import catalogue
from armtwin.models.recordings.writer import arm_table, camera_table
from armtwin.scenarios.scenario import EffectTable
from armtwin.scenarios.serving.faults import checked_fault, declaration
from armtwin.scenarios.serving.job_routes import job_info
from armtwin.scenarios.serving.on_bench import Lease, on_bench
from armtwin.scenarios.serving.visit import Visit
from armtwin.scenarios.serving.wire import (
    BenchInfo,
    Connected,
    Fault,
    FaultsRequest,
    HangRequest,
    JointInfo,
    MoveRequest,
    PlanRequest,
    State,
)


def add_bench(app: FastAPI, visit: Visit) -> None:
    """Add them to an application."""
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
            jobs=[job_info(job) for job in visit.jobs.all()],
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
        await on_bench(visit, live.close)
        visit.lease.end()
        return {"given_back": True}

    @app.post("/api/connect")
    async def connect(lease: Lease = None) -> Connected:
        """Open the bench anew, the arm as it stands when it is switched on."""
        visit.lease.check(lease)
        visit.check_idle()
        await on_bench(visit, live.connect)
        return Connected(notes=list(live.notes), clock_origin_s=live.clock_origin_s)

    @app.post("/api/move")
    async def move(wanted: MoveRequest, lease: Lease = None) -> dict[str, list[float]]:
        """Go to joint angles and answer when the arm rests."""
        visit.lease.check(lease)
        visit.check_idle()
        q = np.array(wanted.q_cmd_rad)
        await on_bench(visit, lambda: live.approach(q) if wanted.approach else live.move(q))
        return {"q_cmd_rad": wanted.q_cmd_rad}

    @app.post("/api/hang")
    async def hang(wanted: HangRequest, lease: Lease = None) -> dict[str, float]:
        """Hang a mass at the tip of a bench that can."""
        visit.lease.check(lease)
        visit.check_idle()
        await on_bench(visit, lambda: live.hang(wanted.payload_kg))
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
