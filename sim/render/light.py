"""One far lamp and light from everywhere: Lambert's law, and shadows projected on a plane."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from models.errors import InputError
from sim.render.parts import Colour, Part

Array = NDArray[np.float64]

# A shadow is drawn this far in front of the plane that it falls on, mm, so that the two do not fight for the depth
# test; parts closer to the plane than this throw none.
SHADOW_LIFT_MM = 0.3


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
    """Prepare the shadows on the part of `parts` that receives them; raises InputError where none does."""
    receiver = next((p for p in parts if p.receives_shadow and p.body is None), None)
    if receiver is None:
        raise InputError("shadows were asked for, but no part of the scene is fixed and receives shadows")
    towards = light.direction
    if towards[2] >= 0.0:
        raise InputError(f"the light comes from behind the plane of {receiver.name!r}; its z must be negative")
    z = float(receiver.mesh.vertices[:, 2].min()) - SHADOW_LIFT_MM
    T = np.eye(4)
    T[:3, 2] -= towards / towards[2]
    T[:3, 3] = towards / towards[2] * z
    red, green, blue = receiver.colour
    return Shadow(T, (light.ambient * red, light.ambient * green, light.ambient * blue))
