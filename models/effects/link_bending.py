"""A link bends under the load beyond it.

The term is a slender cantilever (Euler-Bernoulli) with the weight beyond it as end force and end moment and its own
weight spread along it. Its deflection turns the chord of the link, its slope turns what follows.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from models.effects.context import Context
from models.effects.gravity_sag import needs_gravity
from models.effects.registry import Effect, Parameter, Site, Stage

Array = NDArray[np.float64]


def term(context: Context, q: Array, values: Array, site: Site) -> Array:
    """Angles of the chords of the links when one has the flexibility 1/EI, 1/(N m^2)."""
    flexibility = values[0]
    assert site.joint is not None
    link = site.joint - 1
    masses, tip = context.masses_kg
    length = abs(context.links[link]) * 1e-3
    gravity = complex(*context.arm.gravity_m_s2)
    across = (np.conj(context.directions(q)[:, link]) * gravity).imag  # of gravity, on this link
    end_force = across * (masses[link + 1 :].sum() + tip + context.payload_kg)
    end_moment = context.declared_torque(q)[:, link + 1] if link + 1 < context.arm.n_joints else 0.0
    load = across * masses[link] / length
    chord = end_force * length**2 / 3 + end_moment * length / 2 + load * length**3 / 8
    slope = end_force * length**2 / 2 + end_moment * length + load * length**3 / 6
    out = q.copy()
    out[:, link] += flexibility * chord
    if link + 1 < context.arm.n_joints:
        out[:, link + 1] += flexibility * (slope - chord)
    return out


def _parameters(context: Context, site: Site) -> tuple[Parameter, ...]:
    return (Parameter("flexibility_per_nm2", (0.0, 100.0), 5.0),)


def _starts(context: Context, site: Site, around: Array | None) -> Iterable[Array]:
    return [] if around is not None else [np.array([0.1])]


# --- how the simulated bench makes it ---


def inject(world: Any, parameters: Mapping[str, Any], joint: int | None = None, marker: str | None = None) -> Any:
    """To be written by the physics engineer."""
    raise NotImplementedError


EFFECT = Effect(
    name="link_bending",
    summary="a link bends under the load beyond it",
    where="link",
    stage=Stage.JOINT,
    parameters=_parameters,
    term=term,
    starts=_starts,
    inject=inject,
    confused_with=("gravity_sag", "payload"),
    experiment="the arm turned against gravity, with and without a known mass at the tip",
    applies=needs_gravity,
    plans=("stretched_and_folded", "known_payload"),
)
