"""A horn that slips: a zero that jumps at one sample."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from armtwin.models.catalogue.context import Context
from armtwin.models.catalogue.injection import Injected, sample
from armtwin.models.catalogue.registry import Effect, Parameter, Site, Stage
from armtwin.models.catalogue.scan import event_rows, since
from armtwin.models.world import Event, World, joint_index

Array = NDArray[np.float64]


def term(context: Context, q: Array, values: Array, site: Site) -> Array:
    """Angles whose zero jumps by `jump_rad` at `from_sample`."""
    jump, from_sample = values
    assert site.joint is not None
    out = q.copy()
    out[:, site.joint - 1] += jump * since(context, from_sample)
    return out


def _parameters(context: Context, site: Site) -> tuple[Parameter, ...]:
    return (
        Parameter("jump_rad", (-0.5, 0.5), 0.05),
        Parameter("from_sample", (1.0, float(len(context))), float(len(context)), scanned=True),
    )


def _starts(context: Context, site: Site, around: Array | None) -> Iterable[Array]:
    return [np.array([0.0, row]) for row in event_rows(context, None if around is None else float(around[1]))]


# --- how the simulated bench makes it ---


def inject(world: World, parameters: Mapping[str, Any], joint: int | None = None, marker: str | None = None) -> World:
    """Turn link `joint` on its horn by `jump_rad`, about the axis, just before sample `from_sample`."""
    number = joint_index(world, joint) + 1
    jump, start = float(parameters["jump_rad"]), int(parameters["from_sample"])

    def slip(model: mujoco.MjModel, data: mujoco.MjData) -> None:
        link, turn, seat = model.body(f"link{number}"), np.zeros(4), np.zeros(4)
        mujoco.mju_axisAngle2Quat(turn, model.joint(f"joint{number}").axis, jump)
        mujoco.mju_mulQuat(seat, link.quat, turn)
        link.quat = seat

    return world.with_event(Event(start, slip))


EFFECT = Effect(
    name="joint_slip",
    summary="a horn that slips: a zero that jumps at one sample",
    where="joint",
    stage=Stage.JOINT,
    parameters=_parameters,
    term=term,
    starts=_starts,
    injector=inject,
    injected=(Injected("jump_rad", (-np.pi, np.pi)), sample("from_sample")),
    confused_with=("thermal_drift", "camera_moved"),
    experiment="the poses of the beginning once more",
    plans=("repeat_pose",),
    needs_return=True,
)
