"""A camera file's text, and the documents in it where it is YAML, JSON or OpenCV's XML."""

from __future__ import annotations

import json
import re
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import yaml

from armtwin.models.camera_formats import numpy_archive
from armtwin.models.errors import InputError
from armtwin.models.yaml_loader import load_documents

# A camera file has about 1 kB; OpenCV's calibration samples with all their corner points stay below this, and so do
# mrcal's models with the inputs of their optimisation.
MAX_FILE_BYTES = 4 * 1024 * 1024
# Levels of a matrix in a list in a file of OpenCV.
_DEEPEST = 5
_WANTED = "wanted a camera file (ROS, OpenCV, Kalibr, mrcal, MATLAB, COLMAP, NumPy's npz or armtwin's own)"
# What stands at the start of files that are no text, and what to do with each.
_SAVEZ = "np.savez(file, mtx=…, dist=…, image_size=[w, h])"
_BINARY = {
    b"\x93NUMPY": f"a single array of NumPy's; save matrix, distortion and size together: {_SAVEZ}",
    b"MATLAB 5.0 MAT-file": "a MAT-file of MATLAB's; write it as text: jsonencode(toStruct(cameraParams))",
    b"\x80": f"a pickle, which is never loaded (it can run code); save it by {_SAVEZ}",
}


@dataclass(frozen=True, eq=False)
class Source:
    """The text of a file, read whole; of one that is no text, its arrays by name."""

    text: str
    arrays: dict[str, Any] = field(default_factory=dict)

    @cached_property
    def head(self) -> str:
        """The text from its first line that is neither blank nor a comment."""
        lines = self.text.lstrip().splitlines(keepends=True)
        first = next(
            (i for i, line in enumerate(lines) if line.strip() and not line.lstrip().startswith("#")), len(lines)
        )
        return "".join(lines[first:]).lstrip()

    @cached_property
    def documents(self) -> list[Any]:
        """The documents of a YAML, JSON or XML file.

        Raises:
            InputError: the text is none of them; the message has the line, counted from the file's first.

        """
        if self.arrays:
            return [self.arrays]
        if self.head.startswith("<"):
            return [_from_xml(self.text)]
        if self.head.startswith("{") and '"' in self.head[:200]:
            try:
                return [json.loads(self.text)]
            except json.JSONDecodeError as error:
                raise InputError(f"line {error.lineno}: found no valid JSON ({error.msg}), {_WANTED}") from None
            except (ValueError, RecursionError) as error:
                raise InputError(f"found no valid JSON ({str(error)[:100]}), {_WANTED}") from None
        try:
            # OpenCV's directive, which no YAML library but its own accepts, becomes a comment: lines keep their number.
            return load_documents(re.sub(r"\A%YAML:", "#", self.text))
        except yaml.MarkedYAMLError as error:
            line = f"line {error.problem_mark.line + 1}: " if error.problem_mark else ""
            raise InputError(f"{line}found no valid YAML ({' '.join(str(error.problem).split())}), {_WANTED}") from None
        except (yaml.YAMLError, ValueError, RecursionError) as error:
            reason = " ".join(str(error).split())[:200]
            raise InputError(f"found no valid YAML ({reason}), {_WANTED}") from None

    @property
    def mappings(self) -> list[dict[str, Any]]:
        """The documents that have keys."""
        return [document for document in self.documents if isinstance(document, dict)]


def the_only(cameras: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the one document with a camera; raises InputError where there are several."""
    if len(cameras) > 1:
        raise InputError(f"found {len(cameras)} documents with cameras, wanted one; keep one")
    return cameras[0]


def read_source(path: Path) -> Source:
    """Read a file's text.

    Raises:
        InputError: it cannot be read, is no plain file, is too large or no text; starts with the path.

    """
    if path.exists() and not path.is_file() and not path.is_dir():
        raise InputError(f"{path}: found no plain file (a pipe or a device), {_WANTED}")
    try:
        with path.open("rb") as stream:
            raw = stream.read(MAX_FILE_BYTES + 1)
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}), {_WANTED}") from error
    if len(raw) > MAX_FILE_BYTES:
        raise InputError(f"{path}: found more than {MAX_FILE_BYTES} bytes, {_WANTED} of about 1 kB")
    if raw.startswith(numpy_archive.MARK):
        try:
            return Source("", numpy_archive.arrays(raw))
        except InputError as error:
            raise InputError(f"{path}: {error}") from None
    for mark, what in _BINARY.items():
        if raw.startswith(mark):
            raise InputError(f"{path}: found {what}")
    wide = raw.startswith((b"\xff\xfe", b"\xfe\xff"))  # what some editors save
    try:
        text = raw.decode("utf-16" if wide else "utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: found no text ({error.reason}), {_WANTED}") from None
    return Source(text.replace("\r\n", "\n"))


def _from_xml(text: str) -> dict[str, Any]:
    if "<!DOCTYPE" in text or "<!ENTITY" in text:
        raise InputError(f"found a document type declaration, {_WANTED} without one")
    try:
        root = ElementTree.fromstring(text)  # noqa: S314 (no entities)
    except ElementTree.ParseError as error:
        raise InputError(f"line {error.position[0]}: found no valid XML ({error.msg}), {_WANTED}") from None
    return {child.tag: _value(child) for child in root}


def _value(element: ElementTree.Element, depth: int = 0) -> Any:
    if depth > _DEEPEST:
        raise InputError(f"found XML of more than {_DEEPEST} levels, {_WANTED}")
    if len(element):
        children = {child.tag: _value(child, depth + 1) for child in element}
        if "data" in children:
            children["data"] = [_scalar(word) for word in str(element.findtext("data")).split()]
        return children
    words = (element.text or "").split()
    return _scalar(words[0]) if len(words) == 1 else [_scalar(word) for word in words] or None


def _scalar(word: str) -> int | float | str:
    for kind in (int, float):
        try:
            return kind(word)
        except ValueError:
            continue
    return word
