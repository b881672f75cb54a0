"""What an unexplained remainder looks like, in words: when it comes, what it follows, and where it sits."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.diagnosis.diagnosis import Diagnosis
from armtwin.calib.diagnosis.fit import Data, Fit

Array = NDArray[np.float64]

# At most so many things are said: what a remainder follows least is mostly an echo of the rest.
_MOST_SAID = 3
# A step is one where it explains this much more than a straight line does, and leaves rows on both sides of it.
_STEP_OVER_LINE = 1.3
_LEAST_ROWS = 5
# One place holds a remainder that is this share of all there, in a picture of three by three.
_MOST_OF_IT = 0.6
_ROWS = ("upper", "", "lower")
_COLUMNS = ("left", "middle", "right")


def remainder_in_words(diagnosis: Diagnosis, samples: NDArray[np.int64]) -> str:
    """Return what an unexplained remainder looks like in one sentence; `samples` (N,) are the rows' numbers."""
    parts = looks_like(diagnosis, samples)
    return "" if not parts else f"What remains {', '.join(parts[:-1])}{' and ' if len(parts) > 1 else ''}{parts[-1]}."


def looks_like(diagnosis: Diagnosis, samples: NDArray[np.int64]) -> list[str]:
    """Return what the remainder looks like, as parts of sentences that begin with a verb; plainest first."""
    data, final = diagnosis.explanation.data, diagnosis.explanation.final
    said: list[str] = []
    for trend in diagnosis.trends_after:
        words = _words(trend.against, data, final, samples)
        if words is not None and words not in said:
            said.append(words)
    where = _which_channel(data, final)
    return said[:_MOST_SAID] + ([where] if where else [])


def _words(against: str, data: Data, final: Fit, samples: NDArray[np.int64]) -> str | None:
    context = data.problem.context
    if against.startswith("angle of joint"):
        return f"follows the {against}"
    if "never seen" in against:
        return f"cannot be told of {against}"
    plain: dict[str, Callable[[], str]] = {
        "order": lambda: _when(data, final, samples),
        "time": lambda: _when(data, final, samples),
        "direction of approach": lambda: f"follows the direction from which joint {_direction(data, final)} came",
        "image position": lambda: _in_the_picture(data, final),
        "gravity torque": lambda: "grows with the load that gravity puts on the joints",
        "trajectory": lambda: f"is another one in '{_loudest_trajectory(final, context.trajectory)}' than elsewhere",
        "the pose before": lambda: "goes on from one pose to the next",
        "the same pose's other markers": lambda: "moves all that is seen of a pose together",
        "the noise": lambda: "is louder than the noise and follows nothing that is looked for",
        "the poses held out": lambda: "shows in the poses held out alone",
    }
    return plain[against]() if against in plain else None


def _series(data: Data, final: Fit) -> Array:
    """(N, k) remainder of the channels in standard deviations of the noise, NaN where nothing counts."""
    r = np.where(data.counts[..., None], final.residual, np.nan) / data.noise
    return r.reshape(len(r), -1)


def _when(data: Data, final: Fit, samples: NDArray[np.int64]) -> str:
    """Say that it jumps at a sample, or grows, or comes and goes with time."""
    r = _series(data, final)
    order: Array = np.linspace(-1.0, 1.0, len(r), dtype=np.float64)
    cuts = range(_LEAST_ROWS, len(r) - _LEAST_ROWS)
    steps = [_explained(r, np.where(np.arange(len(r)) >= cut, 1.0, 0.0)) for cut in cuts]
    line = _explained(r, order)
    if steps and max(steps) > _STEP_OVER_LINE * line:
        row = cuts[int(np.argmax(steps))]
        return f"jumps at sample {int(samples[row])}"
    kept = np.isfinite(r).any(axis=1)
    size = np.sqrt(np.nansum(r * r, axis=1) / np.maximum(np.isfinite(r).sum(axis=1), 1))
    rising = float(np.corrcoef(order[kept], size[kept])[0, 1]) if kept.sum() > _LEAST_ROWS else 0.0
    return "grows with time" if rising > 0.3 or line > 0.5 * max(steps, default=0.0) else "comes and goes with time"


def _explained(r: Array, regressor: Array) -> float:
    """Sum of squares that a mean and one regressor (N,) explain of the columns (N, k), beyond their means."""
    total = 0.0
    for y in r.T:
        ok = np.isfinite(y)
        x = regressor[ok] - regressor[ok].mean() if ok.any() else np.zeros(0)
        if float(x @ x) > 0.0:
            total += float(x @ (y[ok] - y[ok].mean())) ** 2 / float(x @ x)
    return total


def _direction(data: Data, final: Fit) -> int:
    """Number of the joint whose direction explains most."""
    q = data.problem.context.q_cmd
    moves = np.sign(np.diff(q, axis=0, prepend=q[:1]))
    r = _series(data, final)
    return 1 + int(np.argmax([_explained(r, column) for column in moves.T]))


def _in_the_picture(data: Data, final: Fit) -> str:
    """Say in which ninth of the picture it sits, or that it changes over all of it."""
    camera = data.problem.context.camera
    assert camera is not None
    seen = np.where(data.counts[..., None], data.problem.observed, np.nan)
    column = np.clip(3.0 * seen[..., 0] / camera.image_width, 0.0, 2.0)
    row = np.clip(3.0 * seen[..., 1] / camera.image_height, 0.0, 2.0)
    beyond = np.maximum(final.misfit - data.problem.observed.shape[-1], 0.0)
    held = np.zeros((3, 3))
    kept = np.isfinite(column) & np.isfinite(row)
    np.add.at(held, (row[kept].astype(int), column[kept].astype(int)), beyond[kept])
    at = np.unravel_index(int(np.argmax(held)), held.shape)
    if held.sum() > 0.0 and held[at] > _MOST_OF_IT * held.sum():
        words = f"{_ROWS[at[0]]} {_COLUMNS[at[1]]}".strip()
        return f"sits in the {words} of the picture"
    return "changes over the picture"


def _loudest_trajectory(final: Fit, trajectory: NDArray[np.str_]) -> str:
    names = list(dict.fromkeys(str(name) for name in trajectory))
    by_pose = final.misfit.sum(axis=1)
    return max(names, key=lambda name: float(by_pose[trajectory == name].mean()))


def _which_channel(data: Data, final: Fit) -> str | None:
    """Say which one marker, or joint, holds most of it, where one does."""
    counted = data.counts.sum(axis=0)
    beyond = np.maximum(final.misfit.sum(axis=0) - data.problem.observed.shape[-1] * counted, 0.0)
    if len(beyond) < 2 or beyond.max() <= _MOST_OF_IT * beyond.sum():
        return None
    name = data.problem.channels[int(np.argmax(beyond))]
    return f"is mostly at {f'marker {name.upper()}' if data.problem.is_pixels else name}"
