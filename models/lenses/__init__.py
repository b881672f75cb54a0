"""Lenses: one model a file, all behind one interface; `lens.py` tells what a lens is, `by_name.py` which there are."""

from armtwin.models.lenses.by_name import MODELS, lens_named, no_distortion
from armtwin.models.lenses.equidistant import Equidistant
from armtwin.models.lenses.lens import Lens
from armtwin.models.lenses.plumb_bob import PlumbBob
from armtwin.models.lenses.rational import Rational
from armtwin.models.lenses.thin_prism import ThinPrism, TiltedThinPrism

__all__ = [
    "MODELS",
    "Equidistant",
    "Lens",
    "PlumbBob",
    "Rational",
    "ThinPrism",
    "TiltedThinPrism",
    "lens_named",
    "no_distortion",
]
