"""What several effects of camera and markers share."""

from __future__ import annotations

from armtwin.models.catalogue.context import Context
from armtwin.models.catalogue.registry import Site


def needs_camera(context: Context, site: Site) -> str | None:
    """Say why an effect of the picture cannot show in this recording, or None."""
    return None if context.camera is not None else "joint angles were measured, not pictures"
