"""Camera models that are tried on the same views, simplest first."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.camera.bundle import free_names
from armtwin.models.lenses import Equidistant, Lens, PlumbBob, Rational, ThinPrism

Array = NDArray[np.float64]


@dataclass(frozen=True)
class CameraModel:
    """A lens, and what is adjusted beside it.

    Attributes:
        name: for the command line and reports.
        lens: the kind of lens.
        centre: whether the principal point is adjusted; else it is the picture's middle.
        bow: whether the board may bow.
        says: what it would mean that this one is the best, for people.

    """

    name: str
    lens: type[Lens]
    centre: bool = True
    bow: bool = False
    says: str = ""

    @property
    def free(self) -> tuple[str, ...]:
        """Names of the adjusted parameters."""
        return free_names(self.lens(np.zeros(len(self.lens.names))), centre=self.centre, bow=self.bow)


MODELS = (
    CameraModel("plumb_bob_centred", PlumbBob, centre=False, says="the views do not tell the principal point"),
    CameraModel("plumb_bob", PlumbBob, says="an ordinary lens"),
    CameraModel("plumb_bob_bowed_board", PlumbBob, bow=True, says="the board is not flat: glue it to a plate"),
    CameraModel("equidistant", Equidistant, says="a fisheye"),
    CameraModel("rational", Rational, says="a wide lens"),
    CameraModel("thin_prism", ThinPrism, says="a lens whose elements stand askew"),
)
USUAL = MODELS[1]


def model_named(name: str) -> CameraModel:
    """Return a model by its name; raises `KeyError` for another."""
    return {model.name: model for model in MODELS}[name]
