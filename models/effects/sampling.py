"""Commands or readings held, repeated, dropped or delayed from a moment on by the bus or the host: all joints alike.

Known forms: a queue that fills, so that from a moment on all commands act later; a bus that answers every second
request, so that readings repeat; a host that skips cycles, so that commands stay in force for several rows.
Covered: later from a moment on; readings or commands held for some rows from a moment on. Not covered: single cycles
that are lost at random, which show as noise.
"""

from __future__ import annotations

from armtwin.models.catalogue.motion_effect import MotionEffect

IN_MOTION = MotionEffect(
    name="sampling",
    summary="from a moment on commands or readings are late, held or dropped: all joints alike",
    where="arm",
    confused_with=("latency",),
    experiment="the same motion again, the host doing nothing else: what falls behind does it elsewhere",
)
