"""Draw a scene through a measured lens."""

from __future__ import annotations

import weakref
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Self

import cv2
import numpy as np
from numpy.typing import NDArray

from armtwin.models.camera import Camera
from armtwin.models.errors import InputError
from armtwin.sim.render.changed import covered_box, outline
from armtwin.sim.render.context import Context, create_context
from armtwin.sim.render.lens import uniforms_of
from armtwin.sim.render.light import Light, shadow_on
from armtwin.sim.render.parts import Part

if TYPE_CHECKING:
    from armtwin.sim.render.painter import Painter

Array = NDArray[np.float64]
Image = NDArray[np.uint8]
LinearImage = NDArray[np.float32]


class LensRenderer:
    """Draws `parts` through `camera`; a context manager, to be closed where it is not used as one.

    While the camera stands still, the parts without a body are drawn once, and after that only the box that the moving
    ones can cover. A camera that changes at every frame costs a whole frame each time.

    Args:
        camera: intrinsics, lens, pose and picture size.
        parts: what to draw; each part's body is looked up in the poses given to `render`.
        supersampling: samples along each side of a pixel.
        shadows: whether the lamp throws shadows on the backdrop.
        light: where the lamp is and how bright.
        background: red, green, blue, 0 to 1, where no part is; a panel behind the scene should leave none.

    Raises:
        InputError: too many bodies, shadows without a backdrop, or a lens that folds back.
        JobError: no off-screen OpenGL on this machine.

    """

    def __init__(
        self,
        camera: Camera,
        parts: Sequence[Part],
        *,
        supersampling: int = 2,
        shadows: bool = False,
        light: Light | None = None,
        background: tuple[float, float, float] = (0.02, 0.02, 0.02),
    ) -> None:
        self._camera = camera
        self._light = light or Light()
        self._shadow = shadow_on(parts, self._light) if shadows else None
        self._bodies = sorted({p.body for p in parts if p.body is not None})
        self._outlines = [(self._bodies.index(p.body), outline(p.mesh)) for p in parts if p.body is not None]
        self._context = create_context()
        from armtwin.sim.render.painter import Painter  # binds PyOpenGL, which must know its platform by then

        size = camera.image_width, camera.image_height
        try:
            with self._context.current():
                self._painter = Painter(size, supersampling, parts, self._bodies, background)
        except BaseException:
            self._context.delete()
            raise
        self._free = weakref.finalize(self, _free, self._context, self._painter)
        self._free.atexit = False  # the process frees it all
        self._seen = b""  # the camera of the last frame, and of the background
        self._background_of = b""
        self._background = np.empty((0, 0, 3), np.uint8)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def render(self, poses: Mapping[str, Array], camera: Camera | None = None) -> Image:
        """Draw one frame: (H, W, 3) uint8, blue, green, red, linear in light.

        `poses` gives each body's (4, 4) T_body_board: the transform that maps body coordinates to the board frame, mm.
        A `camera` stands in for the renderer's own from this frame on; its picture size must be the same.
        Raises InputError for a body without a pose.
        """
        if camera is not None:
            self._change_camera(camera)
        camera = self._camera
        T_body_board = self._stack(poses)
        with self._context.current():
            return self._draw(camera, T_body_board)

    def render_linear(self, poses: Mapping[str, Array], camera: Camera | None = None) -> LinearImage:
        """Draw one frame as `render` does: (H, W, 3) float32, blue, green, red, 1 being full scale."""
        return np.multiply(self.render(poses, camera), np.float32(1.0 / 255.0), dtype=np.float32)

    def close(self) -> None:
        """Free the context; safe to call twice. Other contexts of the process live on."""
        self._free()

    def _draw(self, camera: Camera, T_body_board: Array) -> Image:
        painter = self._painter
        painter.set_view(uniforms_of(camera), camera.T_board_camera, T_body_board, self._light, self._shadow)
        numbers = (camera.K, camera.lens.coefficients, camera.R_board_camera, camera.t_board_camera_mm)
        key = camera.lens.model.encode() + b"".join(a.tobytes() for a in numbers)
        standing, self._seen = key == self._seen, key
        if not standing:
            return _opaque(painter.draw_whole())
        if key != self._background_of:
            self._background = _opaque(painter.draw_background())
            self._background_of = key
        image = self._background.copy()
        if self._outlines:
            u0, v0, u1, v1 = box = covered_box(camera, self._reached(T_body_board))
            if u1 > u0 and v1 > v0:
                image[v0:v1, u0:u1] = _opaque(painter.draw_box(box))
        return image

    def _change_camera(self, camera: Camera) -> None:
        had = self._camera.image_width, self._camera.image_height
        got = camera.image_width, camera.image_height
        if got != had:
            raise InputError(f"a camera of {got[0]}x{got[1]} pixels was given to a renderer of {had[0]}x{had[1]}")
        self._camera = camera

    def _stack(self, poses: Mapping[str, Array]) -> Array:
        missing = [name for name in self._bodies if name not in poses]
        if missing:
            raise InputError(f"no pose was given for {', '.join(missing)}; poses were given for {', '.join(poses)}")
        return np.array([np.eye(4), *(poses[name] for name in self._bodies)])

    def _reached(self, T_body_board: Array) -> Array:
        """(N, 3) board points around the moving parts and their shadows."""
        points = []
        for body, corners in self._outlines:
            T = T_body_board[body + 1]
            points.append(corners @ T[:3, :3].T + T[:3, 3])
        reached = np.vstack(points)
        if self._shadow is None:
            return reached
        F = self._shadow.T_flatten
        return np.vstack([reached, reached @ F[:3, :3].T + F[:3, 3]])


def _opaque(pixels: Image) -> Image:
    """Drop the fourth channel: (H, W, 4) to (H, W, 3)."""
    return np.asarray(cv2.cvtColor(pixels, cv2.COLOR_BGRA2BGR), np.uint8)


def _free(context: Context, painter: Painter) -> None:
    """Free what a renderer holds, in its own context."""
    with context.current():
        painter.delete()
    context.delete()
