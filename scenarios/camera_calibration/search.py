"""Look for a board in many photographs: two at a time, none for longer than a limit, Ctrl-C heard at once.

OpenCV's detectors do not return before they are done, and Python hears Ctrl-C only between calls. So they run in
threads that nobody waits for: the main thread collects what they find, and leaves behind one that takes too long.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from armtwin.calib.camera.corners import Corners
from armtwin.calib.camera.images import Gray, read_gray
from armtwin.scenarios.unwaited import start_unwaited

# A megapixel of the worst clutter takes five seconds of a core; a machine that does much else is slower, and what takes
# longer than this nobody wants to wait for.
LIMIT_S = 30.0
_AT_A_TIME = 2
_POLL_S = 0.02


@dataclass(eq=False)
class Searched:
    """One photograph that was looked at.

    Attributes:
        name: for people.
        size: (width, height), px; zeros where it took too long.
        view: the board's corners, None where it was not found.
        late: whether the search was given up.

    """

    name: str
    size: tuple[int, int] = (0, 0)
    view: Corners | None = None
    late: bool = False


class _Search(threading.Thread):
    """One photograph on its way. A daemon: the process may end while it runs."""

    def __init__(self, name: str, path: Path, find: Callable[[str, Gray], Corners | None]) -> None:
        super().__init__(name=f"search {name}", daemon=True)
        self.found = Searched(name)
        self._path, self._find = path, find
        self.begun = time.monotonic()
        self.error: BaseException | None = None

    def run(self) -> None:
        try:
            image = read_gray(self._path)
            self.found.size = (image.shape[1], image.shape[0])
            self.found.view = self._find(self.found.name, image)
        except BaseException as error:  # noqa: BLE001  # raised again where it is collected
            self.error = error


def search(
    photographs: Sequence[tuple[str, Path]], find: Callable[[str, Gray], Corners | None], limit_s: float = LIMIT_S
) -> Iterator[Searched]:
    """Yield what is found in each of the (name, path), in their order.

    Raises:
        InputError: a photograph cannot be read.

    """
    waiting, running = list(photographs), list[_Search]()
    while waiting or running:
        while waiting and sum(one.is_alive() for one in running) < _AT_A_TIME:
            running.append(_Search(*waiting.pop(0), find))
            start_unwaited(running[-1])
        first = running[0]
        first.join(_POLL_S)
        if first.error is not None:
            raise first.error
        late = first.is_alive() and time.monotonic() - first.begun > limit_s
        if late or not first.is_alive():
            running.pop(0)
            yield Searched(first.found.name, late=True) if late else first.found
