"""Lab 2: a sub-pixel edge, a circle, the bound, and Table 3's bias."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from armtwin.scenarios.labs.check import array, check, copies, number, require
from armtwin.scenarios.labs.material.marker import (
    LENGTHS_MM,
    MEASURED_MM,
    MM_PER_PX,
    REACH_PX,
    photographs,
    read_normals,
    rough_centre,
)

Array = NDArray[np.float64]

# The centre of gravity of the slope scatters by 0.095 px on one edge and by 0.009 px on a disc; whole samples by
# 0.29 px and by 0.031 px.
_EDGE_PX = 0.12
_CENTRE_PX = 0.02


@check("The place of an edge between samples")
def edge(answer: Callable[..., Any]) -> str:
    """Hold an edge finder against edges whose place is known."""
    rng = np.random.default_rng(5)
    x = np.arange(-REACH_PX, REACH_PX + 1.0)
    places = rng.uniform(-1.5, 1.5, 60)
    levels = [40 + 150 * ndtr((place - x) / 1.2) for place in places]
    found = np.array([number(answer(*copies(x, grey)), "edge_position") for grey in levels])
    require(bool(np.ptp(found) > 0.5), "It returns nearly the same place for every edge.")
    require(not np.allclose(found, -places, atol=0.2), "It runs the wrong way: x grows outwards.")
    off = found - places
    require(
        np.abs(off).max() > 0.35 or np.abs(off).max() < 0.15 or not np.allclose(found, np.round(found)),
        "That is the nearest sample. What do the neighbours of the steepest place say?",
    )
    require(np.abs(off).max() < 0.25, f"Without any noise it is up to {np.abs(off).max():.2g} px off.")
    bias = float(off.mean())
    require(abs(bias) < 0.05, f"It is {bias:+.2g} px off on average, for edges at any place: is half a sample lost?")
    noisy = [grey + rng.normal(0, 2.5, len(x)) for grey in levels]
    rms = float(
        np.sqrt(
            np.mean(
                [(number(answer(x, grey), "edge_position") - p) ** 2 for grey, p in zip(noisy, places, strict=True)]
            )
        )
    )
    require(rms < _EDGE_PX, f"With the camera's noise it scatters by {rms:.2g} px; {_EDGE_PX} px is within reach.")
    return f"{rms:.3f} px from one edge alone."


@check("The centre of a circle from points on it")
def circle(answer: Callable[..., Any]) -> str:
    """Hold a circle fit against whole circles and arcs."""
    rng = np.random.default_rng(6)
    for span, what, allowed in ((2 * np.pi, "a whole circle", 0.03), (2.5, "an arc", 0.25)):
        for _ in range(4):
            centre, radius = rng.uniform(-5, 5, 2) + 40, rng.uniform(15, 30)
            angle = rng.uniform(0, 2 * np.pi) + np.sort(rng.uniform(0, span, 80))
            points = centre + radius * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
            exact = array(answer(points.copy()), (2,), "centre_of")
            require(
                not np.allclose(exact, points.mean(axis=0)),
                "That is the mean of the points: it is the centre only where they are spread evenly.",
            )
            require(
                np.allclose(exact, centre, atol=1e-6),
                f"On {what} without noise it is {np.abs(exact - centre).max():.2g} px off.",
            )
            noisy = array(answer(points + rng.normal(0, 0.05, points.shape)), (2,), "centre_of")
            require(
                np.abs(noisy - centre).max() < allowed,
                f"On {what} with noise it is {np.abs(noisy - centre).max():.2g} px off.",
            )
    return "Whole circles and arcs."


@check("Both together, on 60 pictures of a disc")
def chain(edge_position: Callable[..., Any], centre_of: Callable[..., Any]) -> str:
    """Hold the student's own detector against the true centres."""
    off = []
    for photograph in photographs():
        first = rough_centre(photograph.image)
        grey, x, directions = read_normals(photograph.image, first)
        shift = np.array([number(edge_position(x, one), "edge_position") for one in grey])
        points = first + (21.0 + shift)[:, None] * directions
        off.append(array(centre_of(points), (2,), "centre_of") - photograph.centre)
    rms = float(np.sqrt(np.mean(np.square(off))))
    require(
        rms < _CENTRE_PX, f"The centres scatter by {rms:.2g} px; {_CENTRE_PX} px is within reach of these pictures."
    )
    return f"{rms:.4f} px RMS. Compare it with the paper's chain, and with the bound below."


@check("The Cramér–Rao bound of a centre, px")
def bound(answer: Callable[..., Any]) -> str:
    """Hold a bound against the integral."""
    for radius, contrast, blur, noise in ((21.0, 150.0, 1.2, 2.5), (10.0, 80.0, 0.8, 4.0), (40.0, 200.0, 2.0, 1.0)):
        found = number(answer(radius, contrast, blur, noise), "bound_px")
        wanted = float(np.sqrt(2 * blur / (np.sqrt(np.pi) * radius)) * noise / contrast)
        require(found > 0, "A standard deviation is positive.")
        require(
            not np.isclose(found, wanted**2, rtol=0.05), "That is the variance: the bound of the centre is its root."
        )
        require(not np.isclose(found, 1 / wanted, rtol=0.05), "More information makes a smaller bound.")
        require(
            not np.isclose(found, wanted / np.sqrt(2), rtol=0.02),
            "Not all of the edge tells of u: the cosine is missing.",
        )
        require(
            np.isclose(found, wanted, rtol=0.02),
            f"For a disc of {radius:g} px yours is {found / wanted:.3g} times the integral's.",
        )
    return "No unbiased detector whatsoever does better on that picture."


@check("How far outwards does each edge seem to lie in Table 3, px?")
def table_3(answer: Any) -> str:
    """Hold the shift of an edge that explains the common bias."""
    found = number(answer, "edge_shift_px")
    bias_mm = float((MEASURED_MM - LENGTHS_MM).mean())
    wanted = bias_mm / MM_PER_PX / 2
    require(found > 0, "The lengths were measured too long, so the edges seem to lie outwards.")
    require(not np.isclose(found, 2 * wanted, rtol=0.05), "A length has two edges.")
    require(not np.isclose(found, bias_mm, rtol=0.05), "That is in millimetres, for both edges.")
    require(np.isclose(found, wanted, rtol=0.1), "Average the four biases, turn them into pixels, and share them out.")
    return "A threshold a little too low does that; a wrong scale would make 40 mm eight times worse than 5 mm."
