"""A link bends under the load beyond it.

The term is a slender cantilever (Euler-Bernoulli) with the weight beyond it as end force and end moment and its own
weight spread along it. Its deflection turns the chord of the link, its slope turns what follows.

Known forms: slender beams (Euler-Bernoulli: any text on strength of materials), plates and printed bars that also
shear, joints of a link that give in one place. Covered: one slender link under weight. Named otherwise: a link that
gives at its root is `gravity_sag` of its joint. Not covered: creep under load, and twist out of the plane.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

import mujoco
import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from armtwin.models.catalogue import sealed
from armtwin.models.catalogue.context import Context
from armtwin.models.catalogue.injection import Injected
from armtwin.models.catalogue.registry import Effect, Parameter, Site, Stage
from armtwin.models.effects.gravity_sag import needs_gravity
from armtwin.models.mjcf import BEND_AT, HINGE_INERTIA_KG_M2, SPRING_TIME_S
from armtwin.models.world import World, joint_index

Array = NDArray[np.float64]


# How far the outer part of the link, on which the bending lies, has turned beyond its chord, as a part of the chord's
# turn: 2 L^2 + 2 L s - s^2 is the turn of the part beyond s under an end force, 2 L^2 that of the chord; its mean over
# the link, weighted by the lever arm squared, is 2.4 L^2.
_FURTHER = 0.2
_BENT = 3


def term(context: Context, q: Array, values: Array, site: Site) -> Array:
    """Angles of the chords of the links when one has the flexibility 1/EI, 1/(N m^2), bent thrice to find its rest."""
    bent = np.zeros_like(q)
    for _ in range(_BENT):
        bent = _deflection(context, q, bent, values[0], site)
    return q + bent


def _deflection(context: Context, q: Array, bent: Array, flexibility: float, site: Site) -> Array:
    """(N, n) change of the chord angles by the weights at the pose q + bent, both (N, n)."""
    assert site.joint is not None
    link = site.joint - 1
    masses, tip = context.masses_kg
    span = context.links[link]  # points where the calibrated zeros turn it
    length = abs(span) * 1e-3
    gravity = complex(*context.arm.gravity_m_s2)
    turned = np.exp(1j * _FURTHER * bent[:, link]) * span / abs(span)
    across = (np.conj(context.directions(q + bent)[:, link] * turned) * gravity).imag  # of gravity, on this link
    end_force = across * (masses[link + 1 :].sum() + tip + context.payload_kg)
    end_moment = context.declared_torque(q + bent)[:, link + 1] if link + 1 < context.arm.n_joints else 0.0
    load = across * masses[link] / length
    chord = end_force * length**2 / 3 + end_moment * length / 2 + load * length**3 / 8
    slope = end_force * length**2 / 2 + end_moment * length + load * length**3 / 6
    change = np.zeros_like(q)
    change[:, link] = flexibility * chord
    if link + 1 < context.arm.n_joints:
        change[:, link + 1] = flexibility * (slope - chord)
    return change


def _parameters(context: Context, site: Site) -> tuple[Parameter, ...]:
    return (Parameter("flexibility_per_nm2", (0.0, 100.0), 5.0),)


def _starts(context: Context, site: Site, around: Array | None) -> Iterable[Array]:
    return [] if around is not None else [np.array([0.1])]


# --- how the simulated bench makes it ---


def inject(world: World, parameters: Mapping[str, Any], site: Site) -> World:
    """Cut link `joint` at two places and hold its three pieces together by springs.

    `flexibility_per_nm2` is 1/EI of the beam. It bends in the arm's plane, under its own weight and all beyond it.
    """
    number = joint_index(world, site) + 1
    flexibility = float(parameters["flexibility_per_nm2"])
    if flexibility == 0.0:  # a stiff link
        return world

    def mechanism(spec: mujoco.MjSpec) -> None:
        near, far = BEND_AT
        middle, end = spec.body(f"mid{number}"), spec.body(f"end{number}")
        along = np.array(middle.pos) / near
        compliance = flexibility * float(np.linalg.norm(along)) / len(BEND_AT)
        for body, anchor in ((middle, 0.0 * along), (end, (far - 1.0) * along)):
            hinge = body.add_joint(name=f"bend_{body.name}", axis=[0, 0, 1], pos=anchor)
            hinge.armature = HINGE_INERTIA_KG_M2
            hinge.stiffness[0] = 1.0 / compliance
            hinge.damping[0] = SPRING_TIME_S / compliance

    return replace(world, bendable=(*world.bendable, number)).with_mechanism(mechanism)


def _hide(rng: Generator, s: sealed.Situation) -> sealed.Hidden:
    """Draw how it is hidden in a sealed world."""
    # The last link carries only the tip and stands on no other, so its bending is hardly ever seen.
    link = int(rng.integers(1, max(2, s.arm.n_joints)))
    # A printed bar of 12 x 15 mm has about 0.1 per N m2, one of 4 x 10 mm eight times ten of it.
    return sealed.Hidden(lambda a: {"flexibility_per_nm2": a}, 1.0, 8.0, Site(link))


EFFECT = Effect(
    name="link_bending",
    summary="a link bends under the load beyond it",
    where="link",
    stage=Stage.JOINT,
    parameters=_parameters,
    term=term,
    starts=_starts,
    injector=inject,
    injected=(Injected("flexibility_per_nm2", (0.0, 1000.0)),),
    confused_with=("gravity_sag", "payload"),
    experiment="the arm turned against gravity, with and without a known mass at the tip",
    applies=needs_gravity,
    plans=("stretched_and_folded", "known_payload"),
    sealed=sealed.Sealing(_hide, in_gravity=True),
)
