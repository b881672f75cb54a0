"""Camera models held against one another on views that they were not fitted to.

The views are left out in turn, a fold at a time. A model of the others is held against a view of the fold by placing
the board on one half of its points and predicting the other: a lens that is not followed errs there, and a coefficient
too many errs there, too. A richer model is taken only where it predicts better by more than the views differ.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.camera.bundle import BOW, Bundle, adjust, residuals_of
from armtwin.calib.camera.corners import Corners
from armtwin.calib.camera.fit import check_turns, rms_px, rotations_of, upright
from armtwin.calib.camera.models import MODELS, USUAL, CameraModel
from armtwin.calib.camera.start import fit_model
from armtwin.calib.camera.target import Target
from armtwin.models.errors import InputError

Array = NDArray[np.float64]

_FOLDS = 5
# A fold starts where the fit to all views ended: a few steps bring it to where nobody sees a difference.
_STEPS = 8
# Below this many views the folds tell nothing.
LEAST_VIEWS = 5
# A model is better where the mean of its log errors is lower by this many standard errors over the views, and by this
# share: the second keeps a camera simple where views agree on a gain that nobody would notice.
_SIGMAS = 2.0
_LEAST_GAIN = 0.05


@dataclass(frozen=True, eq=False)
class Compared:
    """One model on the views.

    Attributes:
        model: which.
        rms_px: of its fit to all views.
        held_out_px: (V,) root mean square error in each view when it was left out; NaN where it could not be placed.
        bow_mm: (2,) of its fit.

    """

    model: CameraModel
    rms_px: float
    held_out_px: Array
    bow_mm: Array

    @property
    def typical_px(self) -> float:
        """Geometric mean of the held-out errors."""
        return float(np.exp(np.nanmean(np.log(self.held_out_px))))


@dataclass(frozen=True, eq=False)
class Comparison:
    """All models that could be fitted, simplest first, and the one to use."""

    models: tuple[Compared, ...]
    chosen: CameraModel

    def gain(self, model: CameraModel) -> tuple[float, float]:
        """Mean log ratio of a model's held-out errors to the usual one's, and its standard error."""
        return _log_ratio(self._of(model), self._of(USUAL))

    def _of(self, model: CameraModel) -> Compared:
        return next(compared for compared in self.models if compared.model == model)


def compare_models(views: Sequence[Corners], board: Target, image_size: tuple[int, int]) -> Comparison | None:
    """Hold all models against each other; None where there are too few views, or the usual model has no fit.

    Raises:
        InputError: the board was held still.

    """
    if len(views) < LEAST_VIEWS:
        return None
    board, views = upright(views, board, 0)
    points, pixels = [board.points_of(view) for view in views], [view.pixels for view in views]
    compared = []
    for model in MODELS:
        try:
            bundle = fit_model(model, points, pixels, board, image_size)
        except InputError:
            continue
        if model == USUAL:
            check_turns(rotations_of(bundle.poses))
        residuals = residuals_of(bundle, points, pixels)
        compared.append(Compared(model, rms_px(residuals), _held_out(model, bundle, points, pixels), bundle.bow_mm))
    if USUAL not in [one.model for one in compared]:
        return None
    return Comparison(tuple(compared), _choose(compared))


def _choose(compared: Sequence[Compared]) -> CameraModel:
    """The simplest model that none predicts better than, by more than chance and by what anyone would notice."""
    chosen = next(one for one in compared if one.model == USUAL)
    for one in compared:
        mean, error = _log_ratio(one, chosen)
        if mean < -max(_SIGMAS * error, _LEAST_GAIN):
            chosen = one
    return chosen.model


def _log_ratio(one: Compared, other: Compared) -> tuple[float, float]:
    ratio = np.log(one.held_out_px) - np.log(other.held_out_px)
    ratio = ratio[np.isfinite(ratio)]
    if len(ratio) < LEAST_VIEWS:
        return float("nan"), float("nan")
    return float(ratio.mean()), float(ratio.std(ddof=1) / np.sqrt(len(ratio)))


def _held_out(model: CameraModel, fitted: Bundle, points: Sequence[Array], pixels: Sequence[Array]) -> Array:
    """(V,) error in each view by a fit without its fold, started from the fit to all."""
    n = len(points)
    errors = np.full(n, np.nan)
    for fold in range(min(_FOLDS, n)):
        out = [v for v in range(n) if v % min(_FOLDS, n) == fold]
        kept = [v for v in range(n) if v not in out]
        start = Bundle(fitted.K, fitted.lens, fitted.poses[kept], fitted.extent_mm, fitted.bow_mm)
        try:
            fit = adjust(start, [points[v] for v in kept], [pixels[v] for v in kept], model.free, _STEPS)
        except np.linalg.LinAlgError:
            continue
        for view in out:
            errors[view] = _predicted(fit, fitted.poses[view], points[view], pixels[view])
    return errors


def _predicted(fit: Bundle, pose: Array, points: Array, pixels: Array) -> float:
    """Error of each half of a view's points where the board is placed by the other."""
    squares = []
    for half in (0, 1):
        placed, judged = np.arange(len(points)) % 2 == half, np.arange(len(points)) % 2 != half
        start = Bundle(fit.K, fit.lens, pose[None], fit.extent_mm, fit.bow_mm)
        try:
            there = adjust(start, [points[placed]], [pixels[placed]], ())
            squares.append(np.sum(residuals_of(there, [points[judged]], [pixels[judged]])[0] ** 2, axis=1))
        except np.linalg.LinAlgError:
            return float("nan")
    return float(np.sqrt(np.mean(np.concatenate(squares))))


def bow_of(compared: Compared) -> str:
    """A board's bow in words."""
    return " and ".join(f"{value:+.2f} mm along {name[4]}" for name, value in zip(BOW, compared.bow_mm, strict=True))
