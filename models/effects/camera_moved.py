"""The camera was bumped at one sample.

Known forms: a knock, a cable that is pulled, a camera that was taken off and put back. Covered: one move of all six
motions at once. Not covered: several knocks (`unknown`), and shaking from picture to picture, which is noise.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from armtwin.models.camera import Camera
from armtwin.models.catalogue import sealed
from armtwin.models.catalogue.camera_path import CameraPath
from armtwin.models.catalogue.context import Context
from armtwin.models.catalogue.injection import Injected, sample
from armtwin.models.catalogue.registry import Effect, Parameter, Site, Stage
from armtwin.models.catalogue.scan import event_rows, since
from armtwin.models.world import Moment, World

Array = NDArray[np.float64]


def term(context: Context, path: CameraPath, values: Array, site: Site) -> CameraPath:
    """Camera that is turned and shifted from `from_sample` on."""
    after = since(context, values[6])[:, None]
    return path.turned(after * values[:3], after * values[3:6])


def _parameters(context: Context, site: Site) -> tuple[Parameter, ...]:
    return (
        *(Parameter(f"rotation_{axis}_rad", (-0.3, 0.3), 0.02) for axis in "xyz"),
        *(Parameter(f"translation_{axis}_mm", (-100.0, 100.0), 10.0) for axis in "xyz"),
        Parameter("from_sample", (1.0, float(len(context))), float(len(context)), scanned=True),
    )


def _starts(context: Context, site: Site, around: Array | None) -> Iterable[Array]:
    rows = event_rows(context, None if around is None else float(around[6]))
    return [np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, row]) for row in rows]


# --- how the simulated bench makes it ---


def inject(world: World, parameters: Mapping[str, Any], site: Site) -> World:
    """Move the camera just before sample `from_sample`, and leave it there.

    `rotation_x_rad`, ... turn the scene about the camera's axes, `translation_x_mm`, ... then shift it along them;
    a missing one is 0.
    """
    start = int(parameters["from_sample"])
    turn = Rotation.from_rotvec([float(parameters[f"rotation_{axis}_rad"]) for axis in "xyz"]).as_matrix()
    shift = np.array([float(parameters[f"translation_{axis}_mm"]) for axis in "xyz"])

    def bump(camera: Camera, moment: Moment) -> Camera:
        return camera.moved(turn, shift) if moment.sample >= start else camera

    return world.with_camera_motion(bump)


def _hide(rng: Generator, s: sealed.Situation) -> sealed.Hidden:
    """Draw how it is hidden in a sealed world."""
    move, start = sealed.camera_motion(rng), sealed.event(rng, s)
    return sealed.Hidden(lambda a: {**move(a), "from_sample": start}, 0.002, 0.04)


EFFECT = Effect(
    name="camera_moved",
    summary="the camera was bumped at one sample",
    where="camera",
    stage=Stage.CAMERA,
    parameters=_parameters,
    term=term,
    starts=_starts,
    injector=inject,
    injected=(
        *(Injected(f"rotation_{axis}_rad", (-1.0, 1.0), 0.0) for axis in "xyz"),
        *(Injected(f"translation_{axis}_mm", (-400.0, 400.0), 0.0) for axis in "xyz"),
        sample("from_sample"),
    ),
    confused_with=("camera_drift", "joint_slip", "focal_length"),
    experiment="the poses of the beginning once more; marker A, which never moves, tells the camera from the arm",
    needs_camera=True,
    plans=("repeat_pose",),
    needs_return=True,
    sealed=sealed.Sealing(_hide),
)
