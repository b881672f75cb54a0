"""The extended twin of a moving arm: what of the causes can be made physically, and the rest by name."""

from __future__ import annotations

import numpy as np

from armtwin.calib.motion.diagnosis import MotionDiagnosis
from armtwin.models.catalogue.motion_injection import MotionCause, with_causes
from armtwin.models.catalogue.site import Site
from armtwin.models.errors import InputError
from armtwin.models.motion.loop import INDEX
from armtwin.models.motion_world import ideal_motion_world
from armtwin.models.moving_twin import MovingTwin, moving_twin_text


def moving_twin_of(found: MotionDiagnosis) -> MovingTwin:
    """Return the twin that a diagnosis found, with every cause that MuJoCo can be given."""
    return _made(found)[0]


def motion_twin_text(found: MotionDiagnosis, comment: str = "") -> str:
    """Return `twin.toml`: the arm, its zeros, each cause with its parameters, and as comments what it cannot hold."""
    twin, left = _made(found)
    lines = [comment, *(f"Not in this twin: {line}" for line in left)]
    return moving_twin_text(twin, "\n".join(lines))


def _made(found: MotionDiagnosis) -> tuple[MovingTwin, list[str]]:
    zeros = np.array([model.fit.p[INDEX["zero_rad"]] for model in found.arm.joints])
    bare = MovingTwin(found.recording.arm, zeros, ())
    try:
        world = ideal_motion_world(bare.arm, zeros)
    except (InputError, ValueError) as error:
        return bare, [f"any cause: {error}"]
    causes: list[MotionCause] = []
    left: list[str] = []
    for cause in found.causes:
        site, values = Site(joint=cause.joint), {name: one.value for name, one in cause.parameters.items()}
        where = "the whole arm" if cause.joint is None else f"joint {cause.joint}"
        if not values:
            left.append(f"{cause.effect} ({where}), which was of single rows")
            continue
        try:
            with_causes(world, [(cause.effect, site, values)])
            causes.append((cause.effect, site, values))
        except InputError as error:
            left.append(f"{cause.effect} ({where}): {error}")
    return MovingTwin(found.recording.arm, zeros, tuple(causes)), left
