"""Archives of NumPy (`.npz`), in which the Python tutorials of OpenCV keep `mtx` and `dist`."""

from __future__ import annotations

import io
import zipfile
from typing import Any

import numpy as np

from armtwin.models.errors import InputError

# A zip's first bytes.
MARK = b"PK\x03\x04"
# A camera has a few dozen numbers; pictures and corner points, kept beside it by some, are passed over.
_MOST_BYTES = 8 * 128


def arrays(raw: bytes) -> dict[str, Any]:
    """Return the small arrays of an archive by name, as lists; what only pickle could read is never loaded.

    Raises:
        InputError: no archive of arrays.

    """
    try:
        with zipfile.ZipFile(io.BytesIO(raw)) as archive:
            small = [entry for entry in archive.infolist() if entry.file_size <= _MOST_BYTES + 256]
            read = {entry.filename.removesuffix(".npy"): _array(archive.read(entry)) for entry in small}
    except (zipfile.BadZipFile, ValueError, OSError, EOFError, NotImplementedError, RuntimeError) as error:
        raise InputError(f"found no archive of NumPy ({str(error)[:80]}), wanted np.savez's, without objects") from None
    return {name: array.tolist() for name, array in read.items() if array is not None}


def _array(raw: bytes) -> np.ndarray[Any, Any] | None:
    """One member's numbers; None of what holds none."""
    array = np.load(io.BytesIO(raw), allow_pickle=False)
    return array if isinstance(array, np.ndarray) and array.dtype.kind in "iuf" else None
