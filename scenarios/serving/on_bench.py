"""What routes share: the holder's key, and a call that waits for the bench's thread."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Annotated, Any

from fastapi import Header

from armtwin.scenarios.serving.visit import Visit

Lease = Annotated[str | None, Header(alias="X-Lease")]


async def on_bench(visit: Visit, call: Callable[[], Any]) -> Any:
    """Do a call of the holder's in its turn, for which he keeps the arm."""
    with visit.lease.at_work():
        return await asyncio.wrap_future(visit.submit(call))
