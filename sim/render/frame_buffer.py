"""A supersampled off-screen picture: colour and depth."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from OpenGL import GL

from armtwin.models.errors import JobError


class Box(NamedTuple):
    """A rectangle of picture pixels, from (u0, v0) up to but without (u1, v1)."""

    u0: int
    v0: int
    u1: int
    v1: int


class FrameBuffer:
    """Colour and depth of `supersampling` x `supersampling` samples a pixel, in the current context."""

    def __init__(self, width: int, height: int, supersampling: int) -> None:
        self.size = width * supersampling, height * supersampling
        self.supersampling = supersampling
        limit = int(GL.glGetIntegerv(GL.GL_MAX_RENDERBUFFER_SIZE))
        if max(self.size) > limit:
            raise JobError(f"a picture of {self.size[0]}x{self.size[1]} samples is beyond OpenGL's limit of {limit}")
        self._colour, self._depth = (int(b) for b in GL.glGenRenderbuffers(2))
        GL.glBindRenderbuffer(GL.GL_RENDERBUFFER, self._colour)
        GL.glRenderbufferStorage(GL.GL_RENDERBUFFER, GL.GL_RGBA8, *self.size)
        GL.glBindRenderbuffer(GL.GL_RENDERBUFFER, self._depth)
        GL.glRenderbufferStorage(GL.GL_RENDERBUFFER, GL.GL_DEPTH_COMPONENT24, *self.size)
        self._id = int(GL.glGenFramebuffers(1))
        GL.glBindFramebuffer(GL.GL_FRAMEBUFFER, self._id)
        GL.glFramebufferRenderbuffer(GL.GL_FRAMEBUFFER, GL.GL_COLOR_ATTACHMENT0, GL.GL_RENDERBUFFER, self._colour)
        GL.glFramebufferRenderbuffer(GL.GL_FRAMEBUFFER, GL.GL_DEPTH_ATTACHMENT, GL.GL_RENDERBUFFER, self._depth)
        if GL.glCheckFramebufferStatus(GL.GL_FRAMEBUFFER) != GL.GL_FRAMEBUFFER_COMPLETE:
            raise JobError(f"OpenGL refused an off-screen picture of {self.size[0]}x{self.size[1]} samples")

    def bind(self) -> None:
        """Draw into this picture from now on."""
        GL.glBindFramebuffer(GL.GL_FRAMEBUFFER, self._id)
        GL.glViewport(0, 0, *self.size)

    def copy_to(self, target: FrameBuffer, box: Box) -> None:
        """Copy colour and depth of a box of pixels to a picture of the same size, which is left bound."""
        s = self.supersampling
        corners = [c * s for c in box]
        GL.glBindFramebuffer(GL.GL_READ_FRAMEBUFFER, self._id)
        GL.glBindFramebuffer(GL.GL_DRAW_FRAMEBUFFER, target._id)
        planes = GL.GL_COLOR_BUFFER_BIT | GL.GL_DEPTH_BUFFER_BIT
        GL.glBlitFramebuffer(*corners, *corners, planes, GL.GL_NEAREST)
        target.bind()

    def read(self, box: Box) -> NDArray[np.uint8]:
        """Read the samples of a box of pixels: (height, width, 4) uint8 in the channel order that was drawn."""
        s = self.supersampling
        width, height = (box.u1 - box.u0) * s, (box.v1 - box.v0) * s
        samples = np.empty((height, width, 4), np.uint8)
        GL.glBindFramebuffer(GL.GL_READ_FRAMEBUFFER, self._id)
        GL.glReadPixels(box.u0 * s, box.v0 * s, width, height, GL.GL_RGBA, GL.GL_UNSIGNED_BYTE, samples)
        return samples

    def delete(self) -> None:
        """Free the buffers."""
        GL.glDeleteFramebuffers(1, [self._id])
        GL.glDeleteRenderbuffers(2, [self._colour, self._depth])
