"""From photographs, or videos, to a calibrated camera with all that is to be told of it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path

from rich.console import Console
from rich.progress import Progress

from armtwin.calib.camera import MODELS, Board, CameraCalibration, CameraModel, Corners, calibrate_camera
from armtwin.calib.camera.board import MIN_CORNERS
from armtwin.calib.camera.charuco import dictionary_seen
from armtwin.calib.camera.circles import centred
from armtwin.calib.camera.comparison import Comparison, compare_models
from armtwin.calib.camera.corners import find_corners
from armtwin.calib.camera.fit import MIN_VIEWS
from armtwin.calib.camera.images import Found, check_size, read_gray
from armtwin.calib.camera.models import USUAL, model_named
from armtwin.calib.camera.target import Target
from armtwin.calib.camera.video import views_of_video
from armtwin.models.errors import InputError, nearest, shown
from armtwin.scenarios.camera_calibration.search import Searched, search

# How many pictures are searched for a board of another size once the one asked for is nowhere.
_SEARCHED_FOR_OTHERS = 3
AUTOMATIC = "auto"


@dataclass(frozen=True, eq=False)
class Views:
    """What the pictures show.

    Attributes:
        target: the board.
        views: one of each picture, or frame, that shows it.
        size: (width, height) of the pictures, px.
        unseen: names of the pictures in which the board was not found.
        late: those among them in which the search took too long.
        told: lines about files passed over and videos, for people.

    """

    target: Target
    views: tuple[Corners, ...]
    size: tuple[int, int]
    unseen: tuple[str, ...]
    late: tuple[str, ...]
    told: tuple[str, ...]

    def index(self, reference: str | None) -> int:
        """Number of the view whose picture has the name, the first without one; raises InputError for no view."""
        names = [view.name for view in self.views]
        if reference is None:
            return 0
        if reference in names:
            return names.index(reference)
        if reference in self.unseen:
            raise InputError(f"{reference}: found no board of {self.target}, wanted it there; name another one")
        near = nearest(reference, [*names, *self.unseen])
        raise InputError(f"--reference: found {reference!r}, wanted one of the images{near}")


@dataclass(frozen=True, eq=False)
class CameraJob:
    """All results of the command.

    Attributes:
        calibration: the fit to all usable views, which is written.
        seen: what the pictures show.
        comparison: all models on held-out views; None where there are too few.
        variants: other fits to compare with, by what was changed.

    """

    calibration: CameraCalibration
    seen: Views
    comparison: Comparison | None
    variants: dict[str, CameraCalibration] = field(default_factory=dict)


def collect(found: Found, target: Target, window_px: int) -> Views:
    """Search photographs and videos for the board; `window_px` 0 adapts the refinement window to each view.

    Raises:
        InputError: a picture cannot be read or is of another size than the first.

    """
    names = _names(found.images)
    pictures = list(zip(names, found.images, strict=True))
    searched: list[Searched] = []
    told = [f"passed over: {reason}" for _, reason in found.passed_over]
    with _progress(len(pictures)) as tick:
        for one in search(pictures, lambda name, image: target.find(name, image, window_px or None)):
            if one.size != (0, 0) and searched and searched[0].size != (0, 0):
                check_size(one.name, one.size, searched[0].size, searched[0].name)
            searched.append(one)
            tick()
    views = [one.view for one in searched if one.view is not None]
    size = next((one.size for one in searched if one.size != (0, 0)), (0, 0))
    for path in found.videos:
        with _progress(None) as tick:
            added, frame_size, looked = views_of_video(path, target, window_px or None, tick)
        told.append(f"{shown(path.name)}: {len(added)} of {looked} frames used, sharp ones that add most")
        if size == (0, 0):
            size = frame_size
        if frame_size != size:
            raise InputError(f"{path}: found frames of {frame_size[0]}x{frame_size[1]} px, wanted {size[0]}x{size[1]}")
        views += added
    return Views(
        target=target,
        views=tuple(views),
        size=size,
        unseen=tuple(one.name for one in searched if one.view is None),
        late=tuple(one.name for one in searched if one.late),
        told=tuple(told),
    )


def calibrate_views(seen: Views, found: Found, reference: str | None = None, model: str = AUTOMATIC) -> CameraJob:
    """Calibrate from views by the model of a name, or by the one that predicts held-out views best.

    Raises:
        InputError: fewer than three views, too much alike, or an unknown reference.

    """
    if len(seen.views) < MIN_VIEWS:
        raise InputError(_too_few(seen, found))
    at = seen.index(reference)
    if any(view.radius_mm for view in seen.views):
        first = calibrate_camera(seen.views, seen.target, seen.size, at)
        seen = replace(seen, target=first.board, views=centred(first))
    comparison = compare_models(seen.views, seen.target, seen.size)
    chosen = _chosen(model, comparison)
    fit = calibrate_camera(seen.views, seen.target, seen.size, at, chosen)
    variants = {}
    if fit.advice.drop:
        kept = [view for view in seen.views if view.name not in fit.advice.drop]
        again = [view.name for view in kept]
        there = again.index(seen.views[at].name) if seen.views[at].name in again else 0
        variants["poor views dropped"] = calibrate_camera(kept, seen.target, seen.size, there, chosen)
    return CameraJob(fit, seen, comparison, variants)


def _chosen(model: str, comparison: Comparison | None) -> CameraModel:
    if model == AUTOMATIC:
        return USUAL if comparison is None else comparison.chosen
    return model_named(model)


def check_model(model: str) -> None:
    """Refuse a model that there is not.

    Raises:
        InputError: lists those that there are.

    """
    names = [AUTOMATIC, *(one.name for one in MODELS)]
    if model not in names:
        raise InputError(f"--model: found {model!r}, wanted one of {', '.join(names)}{nearest(model, names)}")


def _names(paths: Sequence[Path]) -> list[str]:
    """File names, or whole paths where two folders hold the same file name."""
    count = Counter(path.name for path in paths)
    return [path.name if count[path.name] == 1 else path.as_posix() for path in paths]


def _too_few(seen: Views, found: Found) -> str:
    total = len(seen.views) + len(seen.unseen)
    what = f"found {seen.target} in {len(seen.views)} of {total} images"
    other = None if seen.views else _other_board(found.images[:_SEARCHED_FOR_OTHERS], seen.target)
    if other:
        return (
            f"--board: {what}, but {other} are there; wanted the count of inner corners, "
            f"try --board {other.columns}x{other.rows}"
        )
    markers = None if seen.views or not found.images else dictionary_seen(read_gray(found.images[0]))
    if markers and str(markers) not in str(seen.target):
        return (
            f"--target: {what}, but markers of {markers} are there; for a ChArUco board add --target charuco "
            f"--dictionary {markers}, and count its squares for --board"
        )
    advice = (
        f"not in {', '.join(seen.unseen[:3])}{', …' if len(seen.unseen) > 3 else ''}: show the whole board with its "
        "white margin, sharp and evenly lit, and check --board (inner corners) and --target"
        if seen.unseen
        else "photograph the board from more sides"
    )
    return f"camera calibration: {what}, wanted at least {MIN_VIEWS}; {advice}"


def _other_board(paths: Sequence[Path], target: Target) -> Board | None:
    """A board of nearly the size asked for that the pictures do show: squares were counted, or one miscounted."""
    if not isinstance(target, Board):
        return None
    grays = [read_gray(path) for path in paths]
    around = [(dx, dy) for dx in (-1, 0, 1) for dy in (-1, 0, 1) if (dx, dy) != (0, 0)]
    for dx, dy in around:
        other = replace(target, columns=target.columns + dx, rows=target.rows + dy)
        if min(other.columns, other.rows) < MIN_CORNERS:
            continue
        if any(find_corners(gray, other, thorough=False) is not None for gray in grays):
            return other
    return None


@contextmanager
def _progress(total: int | None) -> Iterator[Callable[[], None]]:
    """A bar on the terminal, none where there is no terminal; calling what it gives moves it on."""
    console = Console(stderr=True)
    with Progress(console=console, transient=True, disable=not console.is_terminal or total == 0) as bar:
        task = bar.add_task("Finding the board", total=total)
        yield lambda: bar.advance(task)
