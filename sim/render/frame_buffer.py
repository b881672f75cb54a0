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
        limit = min(int(GL.glGetIntegerv(limit)) for limit in (GL.GL_MAX_RENDERBUFFER_SIZE, GL.GL_MAX_TEXTURE_SIZE))
        if max(self.size) > limit:
            raise JobError(f"a picture of {self.size[0]}x{self.size[1]} samples is beyond OpenGL's limit of {limit}")
        self.samples = texture(*self.size)
        self._depth = int(GL.glGenRenderbuffers(1))
        GL.glBindRenderbuffer(GL.GL_RENDERBUFFER, self._depth)
        GL.glRenderbufferStorage(GL.GL_RENDERBUFFER, GL.GL_DEPTH_COMPONENT24, *self.size)
        self._id = int(GL.glGenFramebuffers(1))
        GL.glBindFramebuffer(GL.GL_FRAMEBUFFER, self._id)
        GL.glFramebufferTexture2D(GL.GL_FRAMEBUFFER, GL.GL_COLOR_ATTACHMENT0, GL.GL_TEXTURE_2D, self.samples, 0)
        GL.glFramebufferRenderbuffer(GL.GL_FRAMEBUFFER, GL.GL_DEPTH_ATTACHMENT, GL.GL_RENDERBUFFER, self._depth)
        check_whole(self.size)

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
        GL.glDeleteRenderbuffers(1, [self._depth])
        GL.glDeleteTextures(1, [self.samples])


def texture(width: int, height: int) -> int:
    """Return the number of an empty picture of 8 bits a channel that shaders read sample by sample."""
    number = int(GL.glGenTextures(1))
    GL.glBindTexture(GL.GL_TEXTURE_2D, number)
    GL.glTexImage2D(GL.GL_TEXTURE_2D, 0, GL.GL_RGBA8, width, height, 0, GL.GL_RGBA, GL.GL_UNSIGNED_BYTE, None)
    for key in (GL.GL_TEXTURE_MIN_FILTER, GL.GL_TEXTURE_MAG_FILTER):
        GL.glTexParameteri(GL.GL_TEXTURE_2D, key, GL.GL_NEAREST)
    GL.glBindTexture(GL.GL_TEXTURE_2D, 0)
    return number


def check_whole(size: tuple[int, int]) -> None:
    """Raise `JobError` where the picture that is bound cannot be drawn into."""
    if GL.glCheckFramebufferStatus(GL.GL_FRAMEBUFFER) != GL.GL_FRAMEBUFFER_COMPLETE:
        raise JobError(f"OpenGL refused an off-screen picture of {size[0]}x{size[1]} samples")
