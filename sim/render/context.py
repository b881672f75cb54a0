"""An OpenGL context without a display: EGL where its library and a driver are present, OSMesa otherwise.

PyOpenGL binds itself to one of the two when it is first imported, so the choice is made, by asking the libraries
themselves, before anything of pyrender or OpenGL is imported; hence the imports inside the functions below.

A context must not be carried through a fork (the software driver's threads stay behind and the child hangs): start
worker processes with `multiprocessing.get_context("spawn")`.
"""

from __future__ import annotations

import ctypes
import ctypes.util
import os
from typing import Literal, Protocol

from armtwin.models.errors import JobError

_EGL_PLATFORM_DEVICE_EXT = 0x313F  # registry of the extension EGL_EXT_platform_device
_MISSING = (
    "no off-screen OpenGL was found, neither EGL nor OSMesa; "
    "install one with: apt-get install libegl1 libgl1-mesa-dri (or: apt-get install libosmesa6)"
)


class Context(Protocol):
    """What the renderer asks of a context."""

    def make_current(self) -> None:
        """Direct the OpenGL calls that follow to this context."""

    def delete_context(self) -> None:
        """Free the context."""


def egl_works() -> bool:
    """Whether EGL has a device on which a display can be initialised, with no window system."""
    try:
        egl = ctypes.CDLL("libEGL.so.1")
    except OSError:
        return False
    egl.eglGetProcAddress.restype = ctypes.c_void_p
    query = egl.eglGetProcAddress(b"eglQueryDevicesEXT")
    get_display = egl.eglGetProcAddress(b"eglGetPlatformDisplayEXT")
    if not query or not get_display:
        return False
    devices, count = (ctypes.c_void_p * 16)(), ctypes.c_int(0)
    query_devices = ctypes.CFUNCTYPE(ctypes.c_uint, ctypes.c_int, ctypes.c_void_p, ctypes.c_void_p)(query)
    if not query_devices(len(devices), devices, ctypes.byref(count)) or count.value < 1:
        return False
    platform_display = ctypes.CFUNCTYPE(ctypes.c_void_p, ctypes.c_uint, ctypes.c_void_p, ctypes.c_void_p)(get_display)
    display = platform_display(_EGL_PLATFORM_DEVICE_EXT, devices[0], None)
    # The display stays initialised: it is shared by every EGL user of the process, MuJoCo's renderer among them.
    egl.eglInitialize.argtypes = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p]
    return bool(display) and bool(egl.eglInitialize(display, None, None))


def choose_platform() -> Literal["egl", "osmesa"]:
    """Name the way to a context on this machine; raises JobError, naming the packages to install, where there is none.

    An environment variable PYOPENGL_PLATFORM of `egl` or `osmesa` decides beforehand, as PyOpenGL itself would.
    """
    wanted = os.environ.get("PYOPENGL_PLATFORM", "")
    if wanted not in ("", "egl", "osmesa"):
        raise JobError(f"PYOPENGL_PLATFORM is {wanted!r}, which needs a display; unset it, or set it to egl or osmesa")
    if wanted != "osmesa" and egl_works():
        return "egl"
    if wanted != "egl" and ctypes.util.find_library("OSMesa") is not None:
        return "osmesa"
    raise JobError(_MISSING)


def create_context() -> Context:
    """Create a context and make it current; raises JobError where the machine has no off-screen OpenGL."""
    platform = choose_platform()
    os.environ["PYOPENGL_PLATFORM"] = platform
    return _egl_context() if platform == "egl" else _osmesa_context()


def _egl_context() -> Context:
    from OpenGL.EGL import EGL_NO_CONTEXT, EGL_NO_SURFACE, eglDestroyContext, eglMakeCurrent
    from pyrender.platforms.egl import EGLPlatform, get_device_by_index

    class SharedDisplayPlatform(EGLPlatform):  # type: ignore[misc]
        """pyrender's platform would terminate the display, and with it every other EGL context of the process."""

        def delete_context(self) -> None:
            # A context destroyed while it is current would still be found, and restored, by others.
            eglMakeCurrent(self._egl_display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT)
            eglDestroyContext(self._egl_display, self._egl_context)

    context: Context = SharedDisplayPlatform(
        1, 1, device=get_device_by_index(int(os.environ.get("EGL_DEVICE_ID", "0")))
    )
    context.init_context()  # type: ignore[attr-defined]
    return context


def _osmesa_context() -> Context:
    from pyrender.platforms.osmesa import OSMesaPlatform

    platform = OSMesaPlatform(1, 1)
    platform.init_context()
    platform.make_current()
    context: Context = platform
    return context
