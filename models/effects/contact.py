"""Something in the way stops the arm short of its command.

Known forms: a joint's own end stop; the table, another link or a cable under the arm, which stops a joint only in
some poses of the others.
Covered: a stop at one angle of a joint, for one direction. Partly: what stops the arm in some stretches only: their
times are told and their samples are left out of the fit. Not covered: a stop that gives way.
"""

from __future__ import annotations

from armtwin.models.catalogue.motion_effect import MotionEffect

IN_MOTION = MotionEffect(
    name="contact",
    summary="something in the way stops the arm short of its command",
    where="joint",
    confused_with=("torque_limit", "missed_command", "friction"),
    experiment="the same commands with the way free, or moved away from the stop",
)
