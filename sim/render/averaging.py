"""From samples to pixels: the mean of the samples of each, rounded to the nearest level, halves up.

A graphics card averages where it draws, and a quarter of the bytes or less is read back. Software OpenGL fetches
samples slowly (10 ms for a 1280x720 picture of 2x2 samples; reading all and averaging them with OpenCV takes 3 ms), and
there is nothing to be saved on the way. Both give the same bytes.
"""

from __future__ import annotations

from pathlib import Path
from typing import Protocol

import cv2
import numpy as np
from numpy.typing import NDArray
from OpenGL import GL
from pyrender.shader_program import ShaderProgram

from armtwin.sim.render.frame_buffer import Box, FrameBuffer, check_whole, texture

Image = NDArray[np.uint8]

_SHADERS = Path(__file__).parent / "shaders"
# What Mesa's software drivers call themselves.
_SOFTWARE = ("llvmpipe", "softpipe", "swrast", "swr", "software")


class Average(Protocol):
    """Averages the samples of pictures of one size, in the current context."""

    def of(self, frame: FrameBuffer, box: Box) -> Image:
        """Return a box of pixels: (height, width, 4) uint8 in the channel order that was drawn."""

    def delete(self) -> None:
        """Free what it holds."""


def average_for(width: int, height: int) -> Average:
    """Return the quicker way for whatever draws in the current context."""
    return AverageOnProcessor() if draws_in_software() else AverageOnCard(width, height)


def draws_in_software() -> bool:
    """Whether the current context is drawn by the processor."""
    name = (GL.glGetString(GL.GL_RENDERER) or b"").decode("utf-8", "replace").lower()
    return any(word in name for word in _SOFTWARE)


class AverageOnProcessor:
    """Reads all samples back and averages them here."""

    def of(self, frame: FrameBuffer, box: Box) -> Image:
        """Return a box of pixels, as `Average` says."""
        samples = frame.read(box)
        if frame.supersampling == 1:
            return samples
        size = (box.u1 - box.u0, box.v1 - box.v0)
        return np.asarray(cv2.resize(samples, size, interpolation=cv2.INTER_AREA), np.uint8)

    def delete(self) -> None:
        """Hold nothing."""


class AverageOnCard:
    """Averages the samples by a shader, into a picture of its own."""

    def __init__(self, width: int, height: int) -> None:
        self._shaders = ShaderProgram(str(_SHADERS / "average.vert"), str(_SHADERS / "average.frag"))
        self._shaders._add_to_context()
        program = self._shaders._program_id
        self._along = GL.glGetUniformLocation(program, "along")
        self._vertices = int(GL.glGenVertexArrays(1))  # none in it: the shader makes its corners
        self._pixels = texture(width, height)
        self._id = int(GL.glGenFramebuffers(1))
        GL.glBindFramebuffer(GL.GL_FRAMEBUFFER, self._id)
        GL.glFramebufferTexture2D(GL.GL_FRAMEBUFFER, GL.GL_COLOR_ATTACHMENT0, GL.GL_TEXTURE_2D, self._pixels, 0)
        check_whole((width, height))
        self._size = width, height

    def of(self, frame: FrameBuffer, box: Box) -> NDArray[np.uint8]:
        """Return a box of pixels, as `Average` says."""
        u0, v0, width, height = box.u0, box.v0, box.u1 - box.u0, box.v1 - box.v0
        GL.glBindFramebuffer(GL.GL_FRAMEBUFFER, self._id)
        GL.glViewport(0, 0, *self._size)
        for state in (GL.GL_DEPTH_TEST, GL.GL_CULL_FACE, GL.GL_BLEND):
            GL.glDisable(state)
        GL.glEnable(GL.GL_SCISSOR_TEST)
        GL.glScissor(u0, v0, width, height)
        GL.glUseProgram(self._shaders._program_id)
        GL.glUniform1i(self._along, frame.supersampling)
        GL.glActiveTexture(GL.GL_TEXTURE0)
        GL.glBindTexture(GL.GL_TEXTURE_2D, frame.samples)
        GL.glBindVertexArray(self._vertices)
        GL.glDrawArrays(GL.GL_TRIANGLES, 0, 3)
        GL.glBindVertexArray(0)
        GL.glBindTexture(GL.GL_TEXTURE_2D, 0)
        GL.glDisable(GL.GL_SCISSOR_TEST)
        pixels = np.empty((height, width, 4), np.uint8)
        GL.glReadPixels(u0, v0, width, height, GL.GL_RGBA, GL.GL_UNSIGNED_BYTE, pixels)
        return pixels

    def delete(self) -> None:
        """Free the shader, its picture and its vertices."""
        self._shaders.delete()
        GL.glDeleteFramebuffers(1, [self._id])
        GL.glDeleteTextures(1, [self._pixels])
        GL.glDeleteVertexArrays(1, [self._vertices])
