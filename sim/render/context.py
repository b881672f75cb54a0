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
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Literal, Protocol

from armtwin.models.errors import JobError

_EGL_PLATFORM_DEVICE_EXT = 0x313F  # registry of the extension EGL_EXT_platform_device
_MISSING = (
    "no off-screen OpenGL was found, neither EGL nor OSMesa; "
    "install one with: apt-get install libegl1 libgl1-mesa-dri (or: apt-get install libosmesa6)"
)


class _Platform(Protocol):
    """What pyrender calls a platform: one context of EGL or OSMesa."""

    def make_current(self) -> None: ...

    def delete_context(self) -> None: ...


class Context:
    """An OpenGL context that is current only while `current` lasts.

    Objects are freed when Python likes and in whichever thread it likes, in the middle of another renderer's work too.
    So whoever makes OpenGL calls makes his own context current first and hands back what was current before; a context
    that is current nowhere can be used, and freed, in any thread.
    """

    def __init__(self, platform: _Platform, remember: Callable[[], Callable[[], None]]) -> None:
        """Keep a platform's context; `remember` returns what makes that current again which now is."""
        self._platform: _Platform | None = platform
        self._remember = remember

    @contextmanager
    def current(self) -> Iterator[None]:
        """Direct the OpenGL calls of this thread to this context while the block lasts."""
        if self._platform is None:
            raise JobError("this OpenGL context was freed; a closed renderer draws nothing")
        restore = self._remember()
        self._platform.make_current()
        try:
            yield
        finally:
            restore()

    def delete(self) -> None:
        """Free the context; safe to call twice. It must not be current."""
        platform, self._platform = self._platform, None
        if platform is not None:
            platform.delete_context()


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
    """Create a context, current nowhere; raises JobError where the machine has no off-screen OpenGL."""
    platform = choose_platform()
    os.environ["PYOPENGL_PLATFORM"] = platform
    return _egl_context() if platform == "egl" else _osmesa_context()


def _egl_context() -> Context:
    from OpenGL import EGL
    from OpenGL.error import GLError
    from pyrender.platforms.egl import EGLPlatform, get_device_by_index

    class SharedDisplayPlatform(EGLPlatform):  # type: ignore[misc]
        """pyrender's platform would terminate the display, and with it every other EGL context of the process."""

        _egl_context: object

        def delete_context(self) -> None:
            # pyrender calls it once more when the object itself is freed: by then the handle may be another's.
            if self._egl_context is not None:
                EGL.eglDestroyContext(self._egl_display, self._egl_context)
            self._egl_context = None

    platform = SharedDisplayPlatform(1, 1, device=get_device_by_index(int(os.environ.get("EGL_DEVICE_ID", "0"))))

    def remember() -> Callable[[], None]:
        EGL.eglBindAPI(EGL.EGL_OPENGL_API)  # which a thread is asked for anew
        surfaces = [EGL.eglGetCurrentSurface(which) for which in (EGL.EGL_DRAW, EGL.EGL_READ)]
        display, context = EGL.eglGetCurrentDisplay(), EGL.eglGetCurrentContext()

        def restore() -> None:
            if context:
                with suppress(GLError):  # it may have been destroyed while it was current
                    EGL.eglMakeCurrent(display, *surfaces, context)
                    return
            EGL.eglMakeCurrent(platform._egl_display, EGL.EGL_NO_SURFACE, EGL.EGL_NO_SURFACE, EGL.EGL_NO_CONTEXT)

        return restore

    restore = remember()
    platform.init_context()
    context = Context(platform, remember)
    restore()
    return context


def _osmesa_context() -> Context:
    from OpenGL import GL, osmesa
    from pyrender.platforms.osmesa import OSMesaPlatform

    class OnceFreedPlatform(OSMesaPlatform):  # type: ignore[misc]
        def delete_context(self) -> None:
            if self._context is not None:
                super().delete_context()

    def remember() -> Callable[[], None]:
        # OSMesa tells its current context but not the buffer that it draws into, so those are remembered here.
        before = getattr(_current, "platform", None)

        def restore() -> None:
            _current.platform = before
            if before is not None and before._context is not None:
                before.make_current()
            else:
                osmesa.OSMesaMakeCurrent(None, None, GL.GL_UNSIGNED_BYTE, 0, 0)

        _current.platform = platform
        return restore

    platform = OnceFreedPlatform(1, 1)
    platform.init_context()
    return Context(platform, remember)


_current = threading.local()  # `platform`: the OSMesa platform that is current in a thread
