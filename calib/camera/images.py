"""Read the photographs of a calibration: whole, in grey, all of one size."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from armtwin.models.errors import InputError

Gray = NDArray[np.uint8]

SUFFIXES = (".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".webp")
# Photographs of the largest webcams have a tenth of this.
MAX_FILE_BYTES = 128 * 1024 * 1024
# The last bytes of a whole file: decoders fill what is missing with grey, or complain on the terminal.
_ENDS = {b"\xff\xd8": b"\xff\xd9", b"\x89P": b"IEND"}
_END_WITHIN = 4096


def find_images(paths: Sequence[Path]) -> list[Path]:
    """Return the image files that files, folders and glob patterns name, each once, in the order given.

    A folder stands for the images in it, by name.

    Raises:
        InputError: a path names nothing.

    """
    found: dict[Path, Path] = {}
    for path in paths:
        if path.is_dir():
            files = sorted(file for file in path.iterdir() if file.suffix.lower() in SUFFIXES and file.is_file())
            wanted = f"a folder with images ({', '.join(SUFFIXES)})"
        elif path.exists():
            files, wanted = [path], ""
        else:
            # A pattern in quotes, or a shell that leaves patterns to the program.
            base, pattern = Path(path.anchor or "."), str(path.relative_to(path.anchor))
            files = sorted(base.glob(pattern)) if any(mark in pattern for mark in "*?[") else []
            wanted = "an image, a folder of images or a pattern such as 'views/*.png'"
        if not files:
            raise InputError(f"{path}: found no image, wanted {wanted}")
        found.update({file.resolve(): file for file in files if file.resolve() not in found})
    return list(found.values())


def read_gray(path: Path) -> Gray:
    """Read an image as (H, W) uint8 grey levels.

    Raises:
        InputError: the file is missing, too large, cut short or no image.

    """
    try:
        with path.open("rb") as stream:
            raw = stream.read(MAX_FILE_BYTES + 1)
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}), wanted an image") from error
    if len(raw) > MAX_FILE_BYTES:
        raise InputError(f"{path}: found more than {MAX_FILE_BYTES // 2**20} MiB, wanted a photograph")
    end = _ENDS.get(raw[:2], b"")
    image = None
    if raw and end in raw[-_END_WITHIN:]:
        try:
            image = cv2.imdecode(np.frombuffer(raw, np.uint8), cv2.IMREAD_GRAYSCALE)
        except cv2.error as error:  # a size that is not to be believed
            raise InputError(f"{path}: found a corrupt image ({error.err}), wanted a photograph") from error
    if image is None:
        raise InputError(f"{path}: found no image or a corrupt one, wanted a whole photograph; take or copy it again")
    return np.asarray(image, dtype=np.uint8)


def read_views(paths: Sequence[Path]) -> list[Gray]:
    """Read all images of one calibration as grey levels.

    Raises:
        InputError: an image is corrupt, or of another size than the first.

    """
    images = [read_gray(path) for path in paths]
    for path, image in zip(paths, images, strict=True):
        if image.shape != images[0].shape:
            (h, w), (first_h, first_w) = image.shape, images[0].shape
            raise InputError(
                f"{path}: found {w}x{h} px, wanted {first_w}x{first_h} px as {paths[0].name}; "
                "one calibration holds for one camera at one resolution"
            )
    return images
