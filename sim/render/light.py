"""One far lamp and light from everywhere: Lambert's law, and shadows projected on a plane."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armtwin.models.errors import InputError
from armtwin.sim.render.parts import Colour, Part

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Light:
    """A surface of reflectance 1 shows `ambient + diffuse cos(angle to the lamp)`, linear, 1 being full scale.

    Attributes:
        towards: direction to the lamp, board frame, any length; x is left, y up and -z towards the one who looks.
        ambient, diffuse: shares of the light; together at most about 1.2 or white paper is overexposed.

    """

    towards: tuple[float, float, float] = (0.45, 0.75, -1.0)
    ambient: float = 0.55
    diffuse: float = 0.6

    @property
    def direction(self) -> Array:
        """(3,) unit vector towards the lamp, board frame."""
        vector = np.asarray(self.towards, dtype=float)
        unit: Array = vector / np.linalg.norm(vector)
        return unit


@dataclass(frozen=True, eq=False)
class Shadow:
    """Shadows on one plane.

    Attributes:
        T_flatten: (4, 4) maps a board point along the light onto the plane, mm.
        colour: reflectance times light of the plane where it is shadowed.

    """

    T_flatten: Array
    colour: Colour


def shadow_on(parts: Sequence[Part], light: Light) -> Shadow:
    """Prepare the shadows on the backdrop among `parts`; raises InputError where there is none, or no light on it."""
    receiver = next((p for p in parts if p.backdrop), None)
    if receiver is None:
        raise InputError("shadows were asked for, but no part of the scene is a backdrop for them to fall on")
    towards = light.direction
    if towards[2] >= 0.0:
        raise InputError(f"the light comes from behind the plane of {receiver.name!r}; its z must be negative")
    z = float(receiver.mesh.vertices[:, 2].min())
    T = np.eye(4)
    T[:3, 2] -= towards / towards[2]
    T[:3, 3] = towards / towards[2] * z
    red, green, blue = receiver.colour
    return Shadow(T, (light.ambient * red, light.ambient * green, light.ambient * blue))
