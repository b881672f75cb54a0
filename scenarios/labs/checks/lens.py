"""Lab 1: pinhole, equation 15, the fold, calibration from boards."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from armtwin.scenarios.labs.check import array, check, copies, number, require
from armtwin.scenarios.labs.material.lens import TABLE_2, board_mm, camera, views

Array = NDArray[np.float64]

_FOLD_TOLERANCE = 0.003


@check("The pinhole: camera coordinates to pixels")
def pinhole(answer: Callable[..., Any]) -> str:
    """Hold a projection without lens against the reference."""
    K = camera().K
    X = np.random.default_rng(1).uniform([-150, -90, 400], [150, 90, 700], (6, 3))
    found = array(answer(*copies(X, K)), (6, 2), "pinhole")
    places = X[:, :2] / X[:, 2:]
    wanted = places * K[[0, 1], [0, 1]] + K[:2, 2]
    require(not np.allclose(found, wanted - K[:2, 2]), "Your picture has its origin in its middle: what moves it?")
    require(not np.allclose(found, wanted[:, ::-1]), "u and v are exchanged.")
    require(not np.allclose(found, X[:, :2] * K[[0, 1], [0, 1]] + K[:2, 2]), "A point twice as far looks as large.")
    require(np.allclose(found, wanted), f"A point lands {np.linalg.norm(found - wanted, axis=1).max():.3g} px off.")
    nearer = array(answer(X[:1], K), (1, 2), "pinhole")
    require(np.allclose(nearer, wanted[:1]), "It fails for a single point: keep the first axis.")
    return "Six points where they belong."


@check("Equation 15: where the lens puts a point")
def distort(answer: Callable[..., Any]) -> str:
    """Hold a distortion against the model, naming the row that is wrong."""
    points = np.random.default_rng(2).uniform(-0.5, 0.5, (8, 2))
    k = np.array([TABLE_2[name] for name in ("k1", "k2", "p1", "p2", "k3")])
    for only, what in ((0, "k1"), (1, "k2"), (4, "k3"), (2, "p1"), (3, "p2")):
        one = np.where(np.arange(5) == only, k, 0.0)
        found = array(answer(points.copy(), *_in_order(one)), (8, 2), "distort")
        wanted = _with(one, points)
        for row, axis in enumerate("xy"):
            off = float(np.abs(found[:, row] - wanted[:, row]).max())
            require(off < 1e-12, f"With {what} alone, {axis} is off by up to {off:.2g}.{_nudge(what, axis)}")
    found = array(answer(points.copy(), *_in_order(k)), (8, 2), "distort")
    require(np.allclose(found, _with(k, points), atol=1e-12), "Each term is right alone; together they are not.")
    centre = array(answer(np.zeros((1, 2)), *_in_order(k)), (1, 2), "distort")
    require(np.allclose(centre, 0.0), "A point on the axis has to stay there.")
    return "All five terms, alone and together."


@check("The radius at which the polynomial folds back")
def fold(answer: Any) -> str:
    """Hold the radius where the derivative of the radial polynomial vanishes."""
    found = number(answer, "fold_radius")
    r = np.linspace(0.0, 1.0, 200_001)
    slope = 1 + 3 * TABLE_2["k1"] * r**2 + 5 * TABLE_2["k2"] * r**4 + 7 * TABLE_2["k3"] * r**6
    wanted = float(r[np.argmax(slope <= 0)])
    zero = float(r[np.argmax(1 + TABLE_2["k1"] * r**2 + TABLE_2["k2"] * r**4 + TABLE_2["k3"] * r**6 <= 0)])
    require(
        abs(found - zero) > _FOLD_TOLERANCE,
        "There everything lands on the axis. It turns back earlier: where does the curve stop rising?",
    )
    side = "still rises" if found < wanted else "already falls"
    require(abs(found - wanted) < _FOLD_TOLERANCE, f"At {found:.3f} the curve {side}.")
    return "A ray beyond it comes back into the picture, where something else is seen already."


@check("The focal length from tilted boards, px")
def focal_length(answer: Any) -> str:
    """Hold a focal length against the truth by its own uncertainty."""
    found = number(answer, "fx_px")
    truth, (_, std) = float(camera().K[0, 0]), _fx(tilted=True)
    require(found > 100, "A focal length of a webcam is some thousand pixels.")
    off = abs(found - truth)
    require(
        off < 4 * std,
        f"It is {off:.3g} px off, 12 such photographs tell it to about {std:.2g} px. Did all of them go in, "
        "with the picture's size as (width, height)?",
    )
    return f"{off:.2f} px off; that is the corners' noise."


@check("The focal length from boards held square to the view, px")
def square(answer: Any) -> str:
    """Hold a focal length against what the same photographs give here."""
    found = number(answer, "fx_square_px")
    wanted, std = _fx(tilted=False)
    require(
        abs(found - wanted) < 1.0,
        f"These photographs give another one here, {abs(found - wanted):.3g} px away. Is it the set with tilted=False?",
    )
    off = abs(found - float(camera().K[0, 0]))
    return f"OpenCV says ±{std:.2g} px, and it is {off:.0f} px off. See the question below."


def _in_order(k: Array) -> list[float]:
    k1, k2, p1, p2, k3 = (float(one) for one in k)
    return [k1, k2, k3, p1, p2]


def _with(k: Array, points: Array) -> Array:
    rays = np.pad(points, ((0, 0), (0, 1)), constant_values=1.0)
    return np.asarray(cv2.projectPoints(rays, np.zeros(3), np.zeros(3), np.eye(3), k)[0], dtype=float).reshape(-1, 2)


def _nudge(what: str, axis: str) -> str:
    if what in ("p1", "p2"):
        return " A lens does not know which way is up: exchange the axes, p1 and p2, and nothing else may change."
    return ""


@cache
def _fx(*, tilted: bool) -> tuple[float, float]:
    seen = [view.astype(np.float32) for view in views(tilted=tilted)]
    boards = [board_mm().astype(np.float32)] * len(seen)
    size = (camera().image_width, camera().image_height)
    found: Any = cv2.calibrateCameraExtended(boards, seen, size, None, None)  # type: ignore[call-overload]
    return float(found[1][0, 0]), float(found[5].ravel()[0])
