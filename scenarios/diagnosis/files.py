"""Several files written as one: all aside first, then renamed one after the other."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def written_together(folder: Path) -> Iterator[Path]:
    """Yield a folder to write files into; when the block ends well they take their places in `folder`.

    What else `folder` holds is left alone, and where the block fails nothing of it changes.
    """
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=folder, prefix=".", suffix=".part") as name:
        aside = Path(name)
        yield aside
        for path in sorted(aside.iterdir()):
            path.replace(folder / path.name)
