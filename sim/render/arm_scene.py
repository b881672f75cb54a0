"""The arm as solids: 3D-printed bars, hobby servos and disc markers, each in its body's frame.

Bodies are named as in `models.mjcf`: `base`, and for each joint `link1`, `link2` ... and `end1`, `end2` ... The base's
frame is the robot's: origin on marker A, x right, y up, z towards the camera. A link's frame has its origin on the
link's joint axis and x along the link; an end's is the link's, moved to the far end, and carries the marker there. In
every frame z points towards the camera and z = 0 is the plane of the markers; everything else lies behind it:

    z = 0 mm       discs on stickers
    -0.2 ... -4    boss of the last link; those of the links before it are longer
    -4 ... -10     bar of link n
    -11 ... -17    bar of link n-1, and so on, 7 mm a link
    below a bar    the servo that turns it, held by the body before it
"""

from __future__ import annotations

import string
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from armtwin.models.errors import InputError
from armtwin.sim.render.parts import Colour, Part
from armtwin.sim.render.solids import bar, box, circle, extrusion
from armtwin.sim.render.stickers import disc

Array = NDArray[np.float64]

PRINTED: Colour = (0.045, 0.11, 0.30)  # dark blue PLA, dark in the red channel
SERVO: Colour = (0.045, 0.045, 0.050)
BRACKET: Colour = (0.33, 0.34, 0.36)  # bent aluminium
PEN: Colour = (0.10, 0.32, 0.16)

DISC_RADIUS_MM = 7.0  # 21 px in Table 2's picture of the arm's plane
STICKER_RADIUS_MM = 10.5

_STICKER_MM = 0.2  # thickness of paper and glue
_BOSS_RADIUS_MM = 11.0
_BAR_WIDTH_MM = 14.0
_BAR_THICKNESS_MM = 6.0
_LEVEL_MM = 7.0  # from one link's bar to the next
_TOP_MM = -4.0  # front of the last link's bar
_PANEL_MM = -80.87 - 4.5  # the board's plane behind the arm (section 3.2), less the board's thickness

# Body of a standard hobby servo, mm: 40.7 x 19.7 x 36 below its horn, shaft 10 mm from one end, ears 54 mm over all.
_SERVO_MM = (40.7, 19.7, 36.0)
_SERVO_SHAFT_MM = 10.0
_SERVO_EARS_MM = 54.0


def marker_bodies(marker_names: Sequence[str]) -> dict[str, str]:
    """Name the body that carries each of an arm's markers, base first: the base, then the end of each link."""
    return {name: f"end{k}" if k else "base" for k, name in enumerate(marker_names)}


def tip_in_last_link(link_lengths_mm: Sequence[float] | Array, n_joints: int) -> Array:
    """(2,) mm: the tip in the last link's frame, put aside by l5 where there is one (Table 1, equations 2 and 3)."""
    lengths = np.asarray(link_lengths_mm, dtype=float)
    aside = lengths[n_joints] if len(lengths) == n_joints + 1 else 0.0
    return np.array([lengths[n_joints - 1], -aside])


def arm_parts(
    link_lengths_mm: Sequence[float] | Array,
    marker_offsets_mm: Mapping[str, Sequence[float] | Array] | None = None,
    *,
    n_joints: int | None = None,
    disc_radius_mm: float = DISC_RADIUS_MM,
) -> list[Part]:
    """Shape an arm from its lengths: n of them, or four for the paper's three joints (l1, l2, l4, l5).

    `marker_offsets_mm` moves a sticker off its axis, (2,) mm in its body's frame, by marker name. `n_joints` is needed
    only to tell a four-joint arm from the paper's. Raises InputError for a number of lengths that fits neither, and for
    an offset of a marker that the arm does not have.
    """
    lengths = np.asarray(link_lengths_mm, dtype=float)
    n = n_joints if n_joints is not None else (3 if len(lengths) == 4 else len(lengths))
    if not 1 <= n <= 6 or (len(lengths) != n and not (n == 3 and len(lengths) == 4)):
        raise InputError(
            f"an arm of {n} joints needs {n} link lengths (the paper's arm four); {len(lengths)} were given"
        )
    names = ("a", "b", "c", "f") if len(lengths) == n + 1 else tuple(string.ascii_lowercase[: n + 1])
    carriers = marker_bodies(names)
    offsets = dict(marker_offsets_mm or {})
    if unknown := sorted(set(offsets) - set(carriers)):
        raise InputError(f"marker_offsets_mm names {', '.join(unknown)}; this arm's markers are {', '.join(carriers)}")

    parts = _base(n)
    tip = tip_in_last_link(lengths, n)
    for k in range(1, n + 1):
        last = k == n
        far_end = tip if last else np.array([lengths[k - 1], 0.0])
        parts += _link(k, far_end, _bar_top(k, n))
        parts += [] if last else _servo(f"servo {k + 1}", far_end, -far_end / np.linalg.norm(far_end), k, n)
        parts.append(_boss(f"boss {k + 1}", _bar_top(k if last else k + 1, n), f"end{k}"))
    parts += _pen(f"end{n}", tip)
    for name, body in carriers.items():
        x, y = np.asarray(offsets.get(name, (0.0, 0.0)), dtype=float)
        parts.append(disc(f"marker {name}", disc_radius_mm, STICKER_RADIUS_MM, (x, y, 0.0)).on(body))
    return parts


def _bar_top(link: int, n_joints: int) -> float:
    return _TOP_MM - _LEVEL_MM * (n_joints - link)


def _base(n_joints: int) -> list[Part]:
    """Shape what the arm stands on: a foot on the panel, and a bracket that holds the first servo."""
    bracket = box((-16.0, -48.0, _PANEL_MM), (16.0, -20.0, _bar_top(1, n_joints) - 22.0))
    foot = box((-34.0, -58.0, _PANEL_MM), (34.0, 18.0, _PANEL_MM + 5.0))
    return [
        Part("foot", foot, BRACKET, "base"),
        Part("bracket", bracket, BRACKET, "base"),
        *_servo("servo 1", np.zeros(2), np.array([0.0, -1.0]), 0, n_joints),
        _boss("boss 1", _bar_top(1, n_joints), "base"),
    ]


def _link(number: int, end_mm: Array, top_mm: float) -> list[Part]:
    """Shape a bar from the joint's axis to the link's end, with a round hub at either."""
    length = float(np.linalg.norm(end_mm))
    outline = _turned(bar(length, _BAR_WIDTH_MM), end_mm)
    low, body = top_mm - _BAR_THICKNESS_MM, f"link{number}"
    return [
        Part(f"bar {number}", extrusion(outline, low, top_mm), PRINTED, body),
        Part(f"root {number}", extrusion(circle(_BOSS_RADIUS_MM), low, top_mm - 0.5), PRINTED, body),
        Part(f"hub {number}", extrusion(circle(_BOSS_RADIUS_MM) + end_mm, low, top_mm - 0.5), PRINTED, body),
    ]


def _boss(name: str, bar_top_mm: float, body: str) -> Part:
    return Part(name, extrusion(circle(_BOSS_RADIUS_MM), bar_top_mm - 1.0, -_STICKER_MM), PRINTED, body)


def _servo(name: str, shaft_mm: Array, along: Array, held_by: int, n_joints: int) -> list[Part]:
    """Shape the servo that turns link `held_by` + 1; its case reaches from the shaft in the direction `along`."""
    length, width, depth = _SERVO_MM
    ears = 0.5 * (_SERVO_EARS_MM - length)
    top = _bar_top(held_by + 1, n_joints) - _BAR_THICKNESS_MM - 2.0
    body = f"link{held_by}" if held_by else "base"

    def block(start: float, end: float, z_low: float, z_high: float) -> Part:
        solid = box((start, -0.5 * width, z_low), (end, 0.5 * width, z_high))
        solid.vertices[:, :2] = _turned(solid.vertices[:, :2], along) + shaft_mm
        return Part(name, solid, SERVO, body)

    near, far = -_SERVO_SHAFT_MM, length - _SERVO_SHAFT_MM
    return [block(near, far, top - depth, top), block(near - ears, far + ears, top - 10.0, top - 7.5)]


def _pen(body: str, tip_mm: Array) -> list[Part]:
    """Shape a stub of a pen that goes on beyond the tip's marker."""
    outline = np.array([[9.0, -3.0], [30.0, -3.0], [38.0, -0.6], [38.0, 0.6], [30.0, 3.0], [9.0, 3.0]])
    return [Part("pen", extrusion(_turned(outline, tip_mm), _TOP_MM - _BAR_THICKNESS_MM, _TOP_MM - 0.5), PEN, body)]


def _turned(points: Array, along: Array) -> Array:
    """Turn (N, 2) points so that their x axis lies along a direction."""
    c, s = along / np.linalg.norm(along)
    return points @ np.array([[c, s], [-s, c]])
