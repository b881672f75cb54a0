"""One door to both detectors."""

from __future__ import annotations

from armtwin.calib.markers.disc import DetectorConfig, Disc, Image, Method
from armtwin.calib.markers.paper import detect_paper
from armtwin.calib.markers.subpixel import detect_subpixel
from armtwin.models.camera import Camera
from armtwin.models.errors import InputError, nearest


def detect(
    image: Image,
    method: Method = "subpixel",
    camera: Camera | None = None,
    plane_z_mm: float = 0.0,
    config: DetectorConfig | None = None,
) -> tuple[Disc, ...]:
    """Find the discs of a picture, from left to right.

    Args:
        image: (H, W, 3) BGR or (H, W) grey, 8 bits.
        method: "subpixel", or "paper" for the chain of section 3.2.
        camera: makes the centres those of the discs themselves, not of their outlines ("subpixel" only).
        plane_z_mm: the discs' plane z_board, mm; centres are the same for all parallel planes.
        config: sizes, contrast and share of the outline that a disc must have.

    Raises `InputError` for a picture of another kind or size, or an unknown method.

    """
    if camera is not None and image.shape[:2] != (camera.image_height, camera.image_width):
        raise InputError(
            f"picture: {image.shape[1]}x{image.shape[0]} px, the camera was calibrated at "
            f"{camera.image_width}x{camera.image_height}; use pictures of that size or calibrate at this one"
        )
    if method == "subpixel":
        return detect_subpixel(image, camera, plane_z_mm, config)
    if method == "paper":
        return detect_paper(image, config)
    raise InputError(f"method: unknown '{method}'" + nearest(str(method), ("subpixel", "paper")))
