"""What experiments that need a person would separate: the board seen again, a gauge, the camera elsewhere."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import permutations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from armtwin.calib.diagnosis.experiments.poses import (
    CandidatePlan,
    Space,
    calibrate_again,
    camera_elsewhere,
    gauge_in_plane,
)
from armtwin.calib.diagnosis.experiments.rivals import Rivals
from armtwin.calib.diagnosis.fit import Data, Fit
from armtwin.models.camera import Camera
from armtwin.models.catalogue.predict import Active, camera_path, marker_points
from armtwin.models.catalogue.registry import Stage
from armtwin.models.coordinate_frames import robot_to_board

Array = NDArray[np.float64]
Found = list[dict[tuple[int, int], float]]

# As the arm's base plate has room for; twice the noise's variance, since a length has two ends.
_GAUGE_MM = 40.0
_SQUARE_MM = 23.0  # the printed board's, 9 x 6 inner corners
_SIDEWAYS_RAD = np.radians(20.0)


def hand_separation(data: Data, space: Space, groups: list[Rivals]) -> Iterator[tuple[CandidatePlan, Found]]:
    """Yield each experiment by hand with the separations (in standard deviations) that it promises."""
    if space.context.camera is None:
        return
    for candidate, difference in (
        (calibrate_again(space), _by_board),
        (gauge_in_plane(space), _by_gauge),
        (camera_elsewhere(space), _by_view),
    ):
        found: Found = []
        for group in groups:
            pairs: dict[tuple[int, int], float] = {}
            if not any(active is not None and active.effect.stage == Stage.CAMERA for active in group.effects):
                found.append(pairs)  # neither says anything of the camera, so neither would a gauge or another view
                continue
            for true, other in permutations(range(len(group.models)), 2):
                pair = (min(true, other), max(true, other))
                distance = difference(data, candidate, group.models[true], group.models[other])
                pairs[pair] = min(pairs.get(pair, np.inf), distance)
            found.append(pairs)
        yield candidate, found


def _by_board(data: Data, candidate: CandidatePlan, true: Fit, other: Fit) -> float:
    """Distance of two models in one view of the board as the camera stands now, in their noise."""
    problem = data.problem
    assert problem.context.camera is not None
    x, y = np.meshgrid(np.arange(9) * _SQUARE_MM, np.arange(6) * _SQUARE_MM)
    corners = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=-1)
    board = np.broadcast_to(corners, (len(problem.context), *corners.shape))
    seen = [
        camera_path(problem.context, model.effects).project(problem.context.camera, board)[-1]
        for model in (true, other)
    ]
    return float(np.linalg.norm(seen[0] - seen[1])) / data.noise


def _by_gauge(data: Data, candidate: CandidatePlan, true: Fit, other: Fit) -> float:
    """Distance of two models in the seen lengths of a gauge at places that the markers visited, in their noise."""
    lengths = [_gauge_px(data, model, len(candidate.q_cmd)) for model in (true, other)]
    return float(np.linalg.norm(lengths[0] - lengths[1])) / (np.sqrt(2.0) * data.noise)


def _gauge_px(data: Data, model: Fit, places: int) -> Array:
    """(K,) lengths in the picture of a gauge that lies in the arm's plane about the markers' places, by a model."""
    problem = data.problem
    assert problem.context.camera is not None
    rows = np.linspace(0, len(problem.context) - 1, places).astype(int)
    points = marker_points(problem.context, problem.geometry(model.g), problem.context.q_cmd)[:, -1]
    middle = robot_to_board(points, problem.base_in_board_mm)
    ends = 0.5 * _GAUGE_MM * np.array([[-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    board = middle[:, None] + ends  # one lying, one standing
    seen = camera_path(problem.context, model.effects).project(problem.context.camera, board)[rows]
    return np.asarray(np.linalg.norm(seen[:, :2] - seen[:, 2:], axis=-1).ravel())


def _by_view(data: Data, candidate: CandidatePlan, true: Fit, other: Fit) -> float:
    """Distance of two models in a picture from the side, of which what the camera had been accused of is gone."""
    problem = data.problem
    camera = problem.context.camera
    assert camera is not None
    n = len(candidate.q_cmd)
    context = replace(
        problem.context,
        camera=_from_the_side(camera, robot_to_board(np.zeros((1, 3)), problem.base_in_board_mm)[0]),
        q_cmd=candidate.q_cmd,
        payload_kg=candidate.payload_kg,
        trajectory=np.full(n, candidate.name),
        time_s=None,
        commanded_s=None,
        temperature_c=None,
    )
    there = replace(problem, context=context)
    change = there.predict(true.g, _of_the_arm(true.effects)) - there.predict(other.g, _of_the_arm(other.effects))
    _, J = there.predict_with_jacobian(other.g, _of_the_arm(other.effects))
    # The geometry may follow, within what the recording has not fixed: at worst, freely.
    A = J.reshape(-1, J.shape[-1])
    left = change.ravel() - A @ np.linalg.lstsq(A, change.ravel(), rcond=1e-10)[0]
    return float(np.linalg.norm(left)) / data.noise


def _of_the_arm(effects: tuple[Active, ...]) -> tuple[Active, ...]:
    return tuple(active for active in effects if active.effect.stage < Stage.CAMERA)


def _from_the_side(camera: Camera, pivot_board_mm: Array) -> Camera:
    """Return the camera turned about the board's y axis through a point of the arm's plane."""
    turn = Rotation.from_rotvec([0.0, _SIDEWAYS_RAD, 0.0]).as_matrix()
    R = camera.R_board_camera @ turn
    pivot = camera.R_board_camera @ pivot_board_mm + camera.t_board_camera_mm
    return replace(camera, R_board_camera=R, t_board_camera_mm=pivot - R @ pivot_board_mm)
