"""mrcal's `.cameramodel`: a Python literal (http://mrcal.secretsauce.net/cameramodels.html), which is never evaluated.

Its pose is that of a reference frame in the user's own unit, not of the board, so it is left out.
"""

from __future__ import annotations

import ast
import warnings
from typing import Any

from armtwin.models.camera_formats.calibration import Calibration, pinhole
from armtwin.models.camera_formats.matrices import numbers
from armtwin.models.camera_formats.source import Source
from armtwin.models.errors import InputError

# mrcal's names of the lenses that are held here, with the number of coefficients after fx, fy, cx, cy.
_MODELS = {
    "LENSMODEL_PINHOLE": 0,
    "LENSMODEL_OPENCV4": 4,
    "LENSMODEL_OPENCV5": 5,
    "LENSMODEL_OPENCV8": 8,
    "LENSMODEL_OPENCV12": 12,
}
# A literal is parsed into nodes of about 500 bytes; a camera has a hundred values; optimisation inputs are one text.
_MOST_COMMAS = 20_000


def recognises(source: Source) -> bool:
    """Whether the text is a dictionary with a lens model."""
    return source.head.startswith("{") and "lensmodel" in source.text


def read(source: Source) -> Calibration:
    """Read the camera; raises InputError that starts with the key."""
    content = _literal(source.text)
    model = content.get("lensmodel", content.get("lens_model"))
    if not isinstance(model, str) or model not in _MODELS:
        raise InputError(
            f"lensmodel: found {str(model)[:60]!r}, wanted one of {', '.join(_MODELS)}; convert it with "
            "mrcal-convert-lensmodel"
        )
    values = numbers("intrinsics", content.get("intrinsics")).tolist()
    wanted = 4 + _MODELS[model]
    if len(values) != wanted:
        raise InputError(f"intrinsics: found {len(values)} numbers, wanted {wanted} for {model}")
    size = content.get("imagersize", content.get("imager_size"))
    if not isinstance(size, list) or len(size) != 2:
        raise InputError("imagersize: found no two numbers, wanted [width, height]")
    return Calibration(
        width=size[0],
        height=size[1],
        K=pinhole(*values[:4]),
        model="plumb_bob",
        coefficients=values[4:],
        size_keys=("imagersize", "imagersize"),
        matrix_key="intrinsics",
    )


def _literal(text: str) -> dict[str, Any]:
    if text.count(",") > _MOST_COMMAS:
        raise InputError(f"found more than {_MOST_COMMAS} values, wanted mrcal's dictionary of a camera")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # a strange escape in a file is no concern of the terminal
            content = ast.literal_eval(text.strip())
    except SyntaxError as error:
        blank = len(text) - len(text.lstrip())
        line = (error.lineno or 1) + text[:blank].count("\n")
        raise InputError(f"line {line}: found no Python literal ({error.msg}), wanted mrcal's dictionary") from None
    except (ValueError, TypeError, MemoryError, RecursionError):
        raise InputError("found something else than plain values, wanted mrcal's dictionary of them") from None
    if not isinstance(content, dict):
        raise InputError(f"found a {type(content).__name__}, wanted mrcal's dictionary")
    return content
