"""The OpenGL calls of a frame, in the order that makes hidden fragments cheap."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import numpy as np
from numpy.typing import NDArray
from OpenGL import GL

from armtwin.models.errors import InputError
from armtwin.sim.render.averaging import average_for
from armtwin.sim.render.frame_buffer import Box, FrameBuffer
from armtwin.sim.render.lens import LensUniforms
from armtwin.sim.render.light import Light, Shadow
from armtwin.sim.render.parts import Part, merge
from armtwin.sim.render.program import MAX_BODIES, Drawing, LensProgram

Array = NDArray[np.float64]
Image = NDArray[np.uint8]

# Shadows are drawn just before the backdrop and behind all else; the depth buffer tells 2^24 levels apart.
_SHADOW_DEPTH = 1.0 - 2.0**-20


class Painter:
    """Everything that a scene keeps in the current context: programs, merged vertices, frame buffers."""

    def __init__(
        self,
        image_size: tuple[int, int],
        supersampling: int,
        parts: Sequence[Part],
        bodies: Sequence[str],
        background: tuple[float, float, float],
    ) -> None:
        if len(bodies) + 1 > MAX_BODIES:
            raise InputError(f"a scene holds at most {MAX_BODIES - 1} moving bodies; {len(bodies)} were given")
        self.supersampling = supersampling
        self._size = image_size
        self._whole = Box(0, 0, *image_size)
        self._clear = background[::-1]
        index: dict[str | None, int] = {None: 0} | {name: i + 1 for i, name in enumerate(bodies)}

        def upload(chosen: Sequence[Part]) -> list[Drawing]:
            buffers = merge(chosen, index)
            return [] if buffers is None else [Drawing(buffers)]

        self._moving = upload([p for p in parts if p.body is not None and p.ink is None])
        self._moving_ink = upload([p for p in parts if p.body is not None and p.ink is not None])
        self._still = upload([p for p in parts if p.body is None and p.ink is None and not p.backdrop])
        self._still_ink = upload([p for p in parts if p.body is None and p.ink is not None])
        self._backdrop = upload([p for p in parts if p.backdrop])

        self._plain = LensProgram("plain")
        self._inked = LensProgram("inked", inked=True)
        self._shaded = LensProgram("shadow")
        self._frame = FrameBuffer(*image_size, supersampling)
        self._average = average_for(*image_size)
        self._kept: FrameBuffer | None = None
        self._shadow: Shadow | None = None

    def set_view(
        self, lens: LensUniforms, T_board_camera: Array, T_body_board: Array, light: Light, shadow: Shadow | None
    ) -> None:
        """Place the camera, the lamp and the (B, 4, 4) bodies, the first being the board frame itself, mm."""
        self._shadow = shadow
        light_in_body = np.einsum("bji,j->bi", T_body_board[:, :3, :3], light.direction)
        for program in (self._plain, self._inked):
            program.use()
            program.set_lens(lens, self._size)
            program.set_light(light.ambient, light.diffuse)
            program.set_bodies(T_board_camera @ T_body_board, light_in_body)
        if shadow is not None:
            self._shaded.use()
            self._shaded.set_lens(lens, self._size)
            self._shaded.set_shadow(shadow.colour)
            self._shaded.set_bodies(T_board_camera @ shadow.T_flatten @ T_body_board, light_in_body)

    def draw_whole(self) -> Image:
        """Draw all parts: the whole picture, (H, W, 4)."""
        self._frame.bind()
        self._start()
        self._draw(self._plain, self._moving)
        self._draw(self._inked, self._moving_ink)
        self._cast(self._moving)
        self._draw_still()
        return self._average.of(self._frame, self._whole)

    def draw_background(self) -> Image:
        """Draw and keep the parts that stand still: the whole picture, (H, W, 4)."""
        if self._kept is None:
            self._kept = FrameBuffer(*self._size, self.supersampling)
        self._kept.bind()
        self._start()
        self._draw_still()
        return self._average.of(self._kept, self._whole)

    def draw_box(self, box: tuple[int, int, int, int]) -> Image:
        """Draw the moving parts over the kept background: a box of pixels, (height, width, 4)."""
        if self._kept is None:
            raise RuntimeError("draw_background comes before draw_box")
        u0, v0, u1, v1 = box
        s = self.supersampling
        self._kept.copy_to(self._frame, Box(*box))
        self._state()
        GL.glEnable(GL.GL_SCISSOR_TEST)
        GL.glScissor(u0 * s, v0 * s, (u1 - u0) * s, (v1 - v0) * s)
        self._draw(self._plain, self._moving)
        self._draw(self._inked, self._moving_ink)
        self._cast(self._moving)
        GL.glDisable(GL.GL_SCISSOR_TEST)
        return self._average.of(self._frame, Box(*box))

    def delete(self) -> None:
        """Free all of it."""
        for drawing in self._moving + self._moving_ink + self._still + self._still_ink + self._backdrop:
            drawing.delete()
        for program in (self._plain, self._inked, self._shaded):
            program.delete()
        self._frame.delete()
        self._average.delete()
        if self._kept is not None:
            self._kept.delete()

    def _state(self) -> None:
        GL.glEnable(GL.GL_DEPTH_TEST)
        GL.glDepthFunc(GL.GL_LEQUAL)  # the backdrop lies at the very depth that an empty picture has
        GL.glDepthMask(GL.GL_TRUE)
        GL.glDisable(GL.GL_BLEND)
        GL.glDisable(GL.GL_SCISSOR_TEST)
        GL.glDisable(GL.GL_DITHER)
        GL.glEnable(GL.GL_CULL_FACE)
        GL.glCullFace(GL.GL_BACK)
        GL.glFrontFace(GL.GL_CW)  # the picture is drawn top row first, which mirrors it

    def _start(self) -> None:
        self._state()
        GL.glClearColor(*self._clear, 1.0)
        GL.glClear(GL.GL_COLOR_BUFFER_BIT | GL.GL_DEPTH_BUFFER_BIT)

    def _draw(self, program: LensProgram, drawings: Sequence[Drawing]) -> None:
        if drawings:
            program.use()
        for drawing in drawings:
            drawing.draw()

    def _draw_still(self) -> None:
        self._draw(self._plain, self._still)
        self._draw(self._inked, self._still_ink)
        self._cast(self._still)
        with _at_depth(1.0):
            self._draw(self._plain, self._backdrop)

    def _cast(self, drawings: Sequence[Drawing]) -> None:
        """Draw the drawings once more, flattened onto the backdrop in the one colour that it has in the shade.

        The faces that look away from the lamp are culled by their winding, as those that look away from the camera are.
        """
        if self._shadow is not None:
            with _at_depth(_SHADOW_DEPTH):
                self._draw(self._shaded, drawings)


@contextmanager
def _at_depth(depth: float) -> Iterator[None]:
    """Draw everything at one depth, 0 nearest and 1 furthest."""
    GL.glDepthRange(depth, depth)
    yield
    GL.glDepthRange(0.0, 1.0)
