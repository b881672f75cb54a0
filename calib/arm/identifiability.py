"""What can be known: singular values of the Jacobian once the base is projected out, gauge, and ties of the poses.

Seven parameters of planar3, six that can be known: F - C = rho (sin(theta123 - phi), -cos(theta123 - phi)) with
l4 = rho cos(phi), l5 = rho sin(phi), so theta3's zero and a rotation of (l4, l5) are the same motion for every
trajectory. Other parameters may be out of reach of the poses at hand, such as the last link against the base when only
F is seen and its orientation never changes.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.arm.chain import Chain
from armtwin.models.arm import Arm
from armtwin.models.arm_form import Form
from armtwin.models.errors import InputError

Array = NDArray[np.float64]

# Singular values this much smaller than the largest are rounding.
_ROUNDING = 1e-9
# A parameter belongs to an open direction if it makes up at least this share of it.
_SHARE = 0.1
# Commands whose second principal spread is below this share of the first lie on one line.
_LINE = 0.02

GAUGE = (
    "delta_theta3_rad against a rotation of (l4, l5): the same motion of F for every trajectory; convention: the last "
    "link keeps its drawn angle at C (l5 / l4 as drawn), the whole turn stands in delta_theta3_rad"
)


@dataclass(frozen=True, eq=False)
class Identifiability:
    """What the data say about the P link parameters.

    Attributes:
        singular_values: (P,) of the whitened Jacobian in units of the drawing's spread, the base projected out, largest
            first: how many times better the data know a direction than the drawing does. Below 1 it is not known.
        identifiable: how many directions are known.
        gauge: what no trajectory can tell with these markers, and the convention that decides it.
        ties: what these poses leave open beyond that.

    """

    singular_values: Array
    identifiable: int
    gauge: tuple[str, ...]
    ties: tuple[str, ...]


def analyse(chain: Chain, J: Array, markers: tuple[str, ...], q_cmd: Array) -> Identifiability:
    """Analyse the (M, P + 2) Jacobian (link parameters, then base) of M coordinates, in standard deviations of each.

    Raises `InputError` where nothing can be known, or where poses on one line leave link parameters open.
    """
    n_links = len(chain.names)
    values, directions = _singular(J[:, :n_links] * chain.spreads, J[:, n_links:])
    known = (values > 1.0) & (values > _ROUNDING * values[0])
    structural = _structural_rank(chain.arm.form, tuple(chain.arm.link_lengths_mm), markers)
    identifiable = int(known.sum())
    open_names = _open_parameters(chain.names, directions[~known], chain, markers)
    if identifiable == 0:
        raise InputError(
            f"samples.csv: marker {', '.join(markers)} in these {len(q_cmd)} poses says nothing about the arm's links: "
            "measure more markers, or poses in which the joints turn"
        )
    if identifiable < structural and _collinear(q_cmd):
        raise InputError(
            f"samples.csv: the {len(q_cmd)} poses are collinear, the joints move along one line only, and leave "
            f"{structural - identifiable} of {structural} parameters open ({', '.join(open_names)}): "
            "measure poses that turn every joint by itself"
        )
    gauge = (GAUGE,) if chain.has_last_link_gauge(markers) and chain.arm.marker_names[-1] in markers else ()
    ties: tuple[str, ...] = ()
    if open_names:
        ties = (f"these poses and markers leave open {', '.join(open_names)}; they stay near the drawing's values",)
    return Identifiability(values, identifiable, gauge, ties)


def _singular(J_links: Array, J_base: Array) -> tuple[Array, Array]:
    """Singular values and right vectors of J_links once what the base explains is taken out (one QR, base first)."""
    R = np.asarray(np.linalg.qr(np.concatenate([J_base, J_links], axis=1), mode="r"))
    n_base = J_base.shape[1]
    values, Vt = np.linalg.svd(R[n_base:, n_base:])[1:]
    padded = np.zeros(J_links.shape[1])
    padded[: len(values)] = values
    return padded, Vt


@lru_cache(maxsize=64)
def _structural_rank(form: Form, link_lengths_mm: tuple[float, ...], markers: tuple[str, ...]) -> int:
    """How many link parameters of this arm these markers could tell if the poses were as varied as can be."""
    arm = Arm("", np.array(link_lengths_mm), np.zeros(2), form=form)
    chain = Chain(arm)
    q = np.random.default_rng(0).uniform(-np.pi, np.pi, (4 * arm.n_joints + 4, arm.n_joints))
    _, slope = chain.coefficients(np.zeros(len(chain.names)))
    moved = np.concatenate([chain.directions(q, name) @ slope for name in markers]) * chain.spreads
    J_links = np.concatenate([moved.real, moved.imag])
    ones = np.concatenate([np.ones(len(moved)), np.zeros(len(moved))])
    values, _ = _singular(J_links, np.stack([ones, 1.0 - ones], axis=1))
    return int((values > 1e-6 * max(values[0], 1e-300)).sum())


def _open_parameters(
    names: tuple[str, ...], directions: Array, chain: Chain, markers: tuple[str, ...]
) -> tuple[str, ...]:
    """Name the parameters that make up the open directions, the gauge of the last link left out where it is alone."""
    share = np.linalg.norm(directions, axis=0)
    found = tuple(name for name, size in zip(names, share, strict=True) if size > _SHARE)
    alone = len(directions) == 1 and chain.has_last_link_gauge(markers)
    return () if alone and set(found) <= {*chain.length_names[-2:], chain.joint_names[-1]} else found


def _collinear(q_cmd: Array) -> bool:
    spread = np.linalg.svd(q_cmd - q_cmd.mean(axis=0), compute_uv=False)
    return len(spread) < 2 or bool(spread[1] <= _LINE * spread[0])
