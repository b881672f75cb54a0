"""Simulated views of a board through a known camera."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from armtwin.calib.camera.board import Board
from armtwin.calib.camera.corners import Corners
from armtwin.models.camera import Camera, project, rays_of
from armtwin.models.camera_files import nominal_camera
from armtwin.models.lenses import PlumbBob


@pytest.fixture(scope="session")
def board() -> Board:
    return Board(columns=9, rows=6, square_mm=23.0)


@pytest.fixture(scope="session")
def webcam() -> Camera:
    return nominal_camera()


@pytest.fixture(scope="session")
def chessboard_folder() -> Path:
    folder = Path(__file__).resolve().parents[3].parent / "shared" / "data" / "chessboard"
    if not folder.is_dir():
        pytest.skip("the shared chessboard photographs are absent")
    return folder


def _poses(camera: Camera, board: Board, n: int, rng: np.random.Generator) -> list[Camera]:
    """The camera at `n` tilts and distances with the whole board in the picture; the first as the nominal file says."""
    middle = np.array([(board.columns - 1) / 2, (board.rows - 1) / 2, 0.0]) * board.square_mm
    found = [camera]
    limits = np.array([camera.image_width, camera.image_height]) - 12.0
    while len(found) < n:
        turn, _ = cv2.Rodrigues(np.append(rng.uniform(-0.7, 0.7, 2), rng.uniform(-0.3, 0.3)))
        R = turn @ camera.R_board_camera
        ray = rng.uniform(-0.3, 0.3, 2) * [1.0, 0.6]
        depth = rng.uniform(420.0, 700.0)
        view = replace(camera, R_board_camera=R, t_board_camera_mm=depth * np.append(ray, 1.0) - R @ middle)
        pixels = project(view, board.points_mm)
        # Rays beyond r = 0.6 fold back through the nominal polynomial.
        X = board.points_mm @ R.T + view.t_board_camera_mm
        inside = np.all(pixels > 12) and np.all(pixels < limits)
        if inside and np.linalg.norm(X[:, :2] / X[:, 2:], axis=1).max() < 0.55:
            found.append(view)
    return found


@pytest.fixture(scope="session")
def simulate(webcam: Camera, board: Board) -> Callable[..., list[Corners]]:
    """Return a function that gives `n` views with `noise_px` of noise in each coordinate."""

    def views(n: int = 12, noise_px: float = 0.0, seed: int = 0) -> list[Corners]:
        rng = np.random.default_rng(seed)
        pixels = [project(pose, board.points_mm) for pose in _poses(webcam, board, n, rng)]
        return [Corners(f"view {i}", p + rng.normal(0.0, noise_px, p.shape)) for i, p in enumerate(pixels)]

    return views


@pytest.fixture(scope="session")
def photograph() -> Callable[..., np.ndarray]:
    """Return a function that renders a board (dark first square inside) through a camera, blurred, 8 bits."""

    def render(camera: Camera, board: Board, noise: float = 0.0, seed: int = 0) -> np.ndarray:
        fine = 3  # samples a pixel, each way
        w, h = camera.image_width, camera.image_height
        u = (np.arange(w * fine) + 0.5) / fine - 0.5
        v = (np.arange(h * fine) + 0.5) / fine - 0.5
        pixels = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2)
        rays = rays_of(camera, pixels) @ camera.R_board_camera
        centre = -camera.R_board_camera.T @ camera.t_board_camera_mm
        x, y = ((centre - centre[2] / rays[:, 2:] * rays)[:, :2] / board.square_mm).T
        square = np.floor(x).astype(int) + np.floor(y).astype(int)
        on_board = (x > -1) & (x < board.columns) & (y > -1) & (y < board.rows)
        grey = np.where(on_board & (square % 2 == 0), 40.0, 210.0).reshape(h, fine, w, fine).mean(axis=(1, 3))
        grey = cv2.GaussianBlur(grey, (0, 0), 0.7)
        grey += np.random.default_rng(seed).normal(0.0, noise, grey.shape)
        return np.clip(np.rint(grey), 0, 255).astype(np.uint8)

    return render


@pytest.fixture(scope="session")
def small_camera() -> Camera:
    """A camera of few pixels, quick to render, that sees the board upright with some tilt and barrel distortion."""
    R, _ = cv2.Rodrigues(np.array([0.15, -0.25, 0.1]))
    R = R @ np.diag([-1.0, -1.0, 1.0])
    middle = np.array([92.0, 57.5, 0.0])
    return Camera(
        image_width=480,
        image_height=360,
        K=np.array([[520.0, 0.0, 243.0], [0.0, 521.0, 177.0], [0.0, 0.0, 1.0]]),
        lens=PlumbBob(np.array([-0.25, 0.05, 0.001, -0.0005, 0.0])),
        R_board_camera=R,
        t_board_camera_mm=np.array([5.0, -8.0, 400.0]) - R @ middle,
    )
