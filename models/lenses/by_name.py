"""Which lenses there are, by the names and the numbers of coefficients that files give them.

The same lens is the same object whatever a file calls it: a rational model whose added coefficients are zero is a plumb
bob, and no coefficients at all are no distortion.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from armtwin.models.errors import InputError, nearest
from armtwin.models.lenses.equidistant import Equidistant
from armtwin.models.lenses.lens import Lens
from armtwin.models.lenses.plumb_bob import PlumbBob
from armtwin.models.lenses.rational import Rational
from armtwin.models.lenses.thin_prism import ThinPrism, TiltedThinPrism

# Smallest first: the pinhole lenses are one function with more and more coefficients, told apart by their number.
_PINHOLES: tuple[type[Lens], ...] = (PlumbBob, Rational, ThinPrism, TiltedThinPrism)
# ROS's names and the few others in use, with the lenses that each may hold.
MODELS: dict[str, tuple[type[Lens], ...]] = {
    "plumb_bob": _PINHOLES,
    "rational_polynomial": _PINHOLES,
    "thin_prism": _PINHOLES,
    "thin_prism_tilted": _PINHOLES,
    "equidistant": (Equidistant,),
}
_COUNTS = "0, 4, 5, 8, 12 or 14"


def no_distortion() -> Lens:
    """Return a lens that draws straight lines straight."""
    return PlumbBob(np.zeros(5))


def lens_named(model: str, coefficients: Sequence[float] | NDArray[np.float64]) -> Lens:
    """Return the lens of a model's name and its coefficients, OpenCV's order.

    A rectified camera has no coefficients, and often no model.

    Raises:
        InputError: no lens has this name, or this many coefficients; the message starts with the key.

    """
    if model.lower() in ("", "none") and not np.any(coefficients):
        return no_distortion()
    if model not in MODELS:
        raise InputError(
            f"distortion_model: found {model!r}, wanted one of {', '.join(MODELS)}{nearest(model, MODELS)}; "
            "calibrate with one of those"
        )
    values = np.asarray(coefficients, dtype=float).ravel()
    if not values.size:
        return no_distortion() if Equidistant not in MODELS[model] else Equidistant(np.zeros(4))
    if Equidistant in MODELS[model]:
        if np.any(values[4:]) or values.size < 4:
            raise _wrong_count(model, values.size, "4 (k1, k2, k3, k4)")
        return Equidistant(values[:4].copy())
    return _pinhole(model, values)


def _pinhole(model: str, values: NDArray[np.float64]) -> Lens:
    if values.size != 4 and values.size not in (len(kind.names) for kind in _PINHOLES):
        raise _wrong_count(model, values.size, f"{_COUNTS} in OpenCV's order (k1, k2, p1, p2, k3, k4, ...)")
    padded = np.concatenate([values, np.zeros(max(5 - values.size, 0))])
    for kind in _PINHOLES:
        count = len(kind.names)
        if padded.size == count or not np.any(padded[count:]):
            return kind(padded[:count].copy())
    raise AssertionError("the last pinhole lens has as many coefficients as there can be")


def _wrong_count(model: str, found: int, wanted: str) -> InputError:
    return InputError(f"distortion_coefficients: found {found} numbers for '{model}', wanted {wanted}")
