"""The lens shader with one of its three surfaces, and the merged vertices it draws."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from OpenGL import GL
from pyrender.primitive import Primitive
from pyrender.shader_program import ShaderProgram

from armtwin.sim.render.lens import LensUniforms
from armtwin.sim.render.parts import Buffers, Colour

Array = NDArray[np.float64]

SHADERS = Path(__file__).parent / "shaders"
MAX_BODIES = 32  # as in lens.vert
# mm; nothing of a bench is nearer or further. 24 bits over this range resolve 0.0002 mm at half a metre.
DEPTH_RANGE_MM = (60.0, 4000.0)


class LensProgram:
    """A compiled pair of shaders in the current context; `surface` names the fragment shader."""

    def __init__(self, surface: str, *, inked: bool = False) -> None:
        self._shaders = ShaderProgram(
            str(SHADERS / "lens.vert"), str(SHADERS / f"{surface}.frag"), defines={"INKED": 1} if inked else None
        )
        self._shaders._add_to_context()
        self._id = self._shaders._program_id
        self._locations: dict[str, int] = {}

    def use(self) -> None:
        """Draw with these shaders from now on."""
        GL.glUseProgram(self._id)

    def set_lens(self, lens: LensUniforms, image_size: tuple[int, int]) -> None:
        """Set the lens, for pictures of `image_size` pixels."""
        GL.glUniformMatrix3fv(self._at("K"), 1, GL.GL_TRUE, np.ascontiguousarray(lens.K, np.float32))
        GL.glUniform1i(self._at("fisheye"), lens.fisheye)
        GL.glUniform4f(self._at("radial"), *lens.radial)
        GL.glUniform3f(self._at("divisor"), *lens.divisor)
        GL.glUniform2f(self._at("tangential"), *lens.tangential)
        GL.glUniform4f(self._at("prism"), *lens.prism)
        GL.glUniform1f(self._at("linear_from"), lens.linear_from)
        GL.glUniform2f(self._at("image_size"), *image_size)
        GL.glUniform2f(self._at("depth_range"), *DEPTH_RANGE_MM)

    def set_bodies(self, T_camera_body: Array, light_in_body: Array) -> None:
        """Set the (B, 4, 4) poses, mm, and the (B, 3) directions towards the light."""
        count = len(T_camera_body)
        GL.glUniformMatrix4fv(self._at("T_camera_body"), count, GL.GL_TRUE, np.asarray(T_camera_body, np.float32))
        GL.glUniform3fv(self._at("light_in_body"), count, np.ascontiguousarray(light_in_body, np.float32))

    def set_light(self, ambient: float, diffuse: float) -> None:
        """Set the share of light from everywhere and the share from the lamp."""
        GL.glUniform2f(self._at("light"), ambient, diffuse)

    def set_shadow(self, colour: Colour) -> None:
        """Set what a shadowed surface shows."""
        GL.glUniform3f(self._at("shadow"), *colour[::-1])

    def delete(self) -> None:
        """Free the shaders."""
        self._shaders.delete()

    def _at(self, name: str) -> int:
        if name not in self._locations:
            self._locations[name] = GL.glGetUniformLocation(self._id, name)
        return self._locations[name]


class Drawing:
    """Merged vertices in the current context, drawn by one call. pyrender's glTF slots carry what the shader needs."""

    def __init__(self, buffers: Buffers) -> None:
        printed = buffers.ink is not None
        self._primitive = Primitive(
            positions=buffers.positions,
            normals=buffers.normals,
            tangents=_opaque(buffers.ink) if buffers.ink is not None else None,
            texcoord_0=np.column_stack([buffers.body, np.zeros_like(buffers.body)]),
            texcoord_1=buffers.edges if printed else None,
            color_0=_opaque(buffers.paint),
            indices=buffers.faces,
        )
        self._primitive._add_to_context()

    def draw(self) -> None:
        """Draw with the program in use."""
        self._primitive._bind()
        GL.glDrawElements(GL.GL_TRIANGLES, self._primitive.indices.size, GL.GL_UNSIGNED_INT, None)
        self._primitive._unbind()

    def delete(self) -> None:
        """Free the vertices."""
        self._primitive.delete()


def _opaque(colours: Array) -> Array:
    return np.column_stack([colours, np.ones(len(colours))])
