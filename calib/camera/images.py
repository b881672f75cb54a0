"""Read the photographs of a calibration: whole, in grey, as the sensor saw them, within bounds.

A camera notes how it was held (EXIF orientation) beside a picture; turning the picture by it would turn the lens with
it, so the note is not followed: photographs held upright and sideways are pictures of one lens.
"""

from __future__ import annotations

import io
import re
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image

from armtwin.models.errors import InputError, shown

Gray = NDArray[np.uint8]

SUFFIXES = (".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".webp")
VIDEO_SUFFIXES = (".mp4", ".mov", ".avi", ".mkv", ".webm", ".m4v", ".mts")
# Photographs of the largest cameras have about this.
MAX_FILE_BYTES = 128 * 1024 * 1024
# Telephones take photographs of 12 to 108 megapixels; in grey that is as many bytes.
MAX_PIXELS = 120_000_000
# The last bytes of a whole file: decoders fill what is missing with grey, or complain on the terminal.
_ENDS = {b"\xff\xd8": b"\xff\xd9", b"\x89P": b"IEND"}
_END_WITHIN = 4096
_HEIF_BRANDS = (b"heic", b"heix", b"hevc", b"heim", b"heis", b"mif1", b"msf1")
_HEIF = (
    "a HEIC photograph, wanted JPEG or PNG; convert it (heif-convert, or any picture viewer), and set an iPhone's "
    "camera to 'Most Compatible'"
)


@dataclass
class Found:
    """What files, folders and patterns name, each once, in the order given.

    Attributes:
        images, videos: files.
        passed_over: files of folders that are neither, with the reason.

    """

    images: list[Path] = field(default_factory=list)
    videos: list[Path] = field(default_factory=list)
    passed_over: list[tuple[Path, str]] = field(default_factory=list)


def find_images(paths: Sequence[Path]) -> Found:
    """Return the photographs and videos that files, folders and glob patterns name.

    A folder stands for the photographs and videos in it, by name.

    Raises:
        InputError: a path names nothing.

    """
    found, known = Found(), set()
    for path in paths:
        if path.is_dir():
            files = sorted(file for file in path.iterdir() if file.is_file() and not file.name.startswith("."))
            wanted = f"a folder with images ({', '.join(SUFFIXES)})"
        elif path.exists():
            files, wanted = [path], ""
            if not path.is_file():
                raise InputError(f"{path}: found no plain file (a pipe or a device), wanted a photograph")
        else:
            # A pattern in quotes, or a shell that leaves patterns to the program.
            base, pattern = Path(path.anchor or "."), str(path.relative_to(path.anchor))
            files = sorted(base.glob(pattern)) if any(mark in pattern for mark in "*?[") else []
            wanted = "an image, a folder of images or a pattern such as 'views/*.png'"
        of_use = 0
        for file in files:
            reason = _why_not(file) if path.is_dir() else ""
            if reason:
                found.passed_over.append((file, reason))
            elif file.resolve() not in known:
                (found.videos if file.suffix.lower() in VIDEO_SUFFIXES else found.images).append(file)
            known.add(file.resolve())
            of_use += not reason
        if not of_use:
            heif = sum("HEIC" in reason for _, reason in found.passed_over)
            seen = f"found {heif} HEIC photographs and no other, wanted JPEG or PNG; convert them" if heif else ""
            raise InputError(f"{path}: {seen or f'found no image, wanted {wanted}'}")
    return found


def read_gray(path: Path) -> Gray:
    """Read an image as (H, W) uint8 grey levels, as it lies in the file.

    Raises:
        InputError: the file is missing, no plain file, too large, cut short or no image.

    """
    if path.exists() and not path.is_file() and not path.is_dir():
        raise InputError(f"{path}: found no plain file (a pipe or a device), wanted a photograph")
    try:
        with path.open("rb") as stream:
            raw = stream.read(MAX_FILE_BYTES + 1)
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}), wanted an image") from error
    if len(raw) > MAX_FILE_BYTES:
        raise InputError(f"{path}: found more than {MAX_FILE_BYTES // 2**20} MiB, wanted a photograph")
    if raw[4:8] == b"ftyp" and raw[8:12] in _HEIF_BRANDS:
        raise InputError(f"{path}: found {_HEIF}")
    pixels = _pixels_of(raw)
    if pixels > MAX_PIXELS:
        raise InputError(
            f"{path}: found {pixels // 10**6} megapixels, wanted a photograph of at most {MAX_PIXELS // 10**6}; "
            "take it smaller"
        )
    image = None
    if pixels and _ENDS.get(raw[:2], b"") in raw[-_END_WITHIN:]:
        try:
            flags = cv2.IMREAD_GRAYSCALE | cv2.IMREAD_IGNORE_ORIENTATION
            image = cv2.imdecode(np.frombuffer(raw, np.uint8), flags)
        except cv2.error as error:  # a size that is not to be believed
            raise InputError(f"{path}: found a corrupt image ({error.err}), wanted a photograph") from error
    if image is None:
        raise InputError(f"{path}: found no image or a corrupt one, wanted a whole photograph; take or copy it again")
    return np.asarray(image, dtype=np.uint8)


def check_size(name: str, size: tuple[int, int], wanted: tuple[int, int], first: str) -> None:
    """Refuse a picture of another size, (width, height) px, than the first.

    Raises:
        InputError: names both.

    """
    if size != wanted:
        turned = "; one of the two was turned by a program, take the original" if size == wanted[::-1] else ""
        raise InputError(
            f"{name}: found {size[0]}x{size[1]} px, wanted {wanted[0]}x{wanted[1]} px as {first}; "
            f"one calibration holds for one camera at one resolution{turned}"
        )


def _pixels_of(raw: bytes) -> int:
    """Number of pixels by the file's head, before anything is decoded; 0 where it is no image."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # sizes are judged here
            with Image.open(io.BytesIO(raw)) as image:
                return image.width * image.height
    except Image.DecompressionBombError as error:
        found = re.search(r"(\d+) pixels", str(error))
        return int(found.group(1)) if found else MAX_PIXELS + 1
    except Exception:  # noqa: BLE001  # whatever its many readers raise, it is no image
        return 0


def _why_not(file: Path) -> str:
    suffix = file.suffix.lower()
    if suffix in (".heic", ".heif"):
        return f"{shown(file.name)} is a HEIC photograph: convert it to JPEG"
    if suffix not in SUFFIXES + VIDEO_SUFFIXES:
        return f"{shown(file.name)} is no photograph"
    return ""
