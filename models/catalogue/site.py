"""Where an effect sits."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Site:
    """A joint, link or axis number counted from 1, a marker's name, or neither: the whole arm or the camera."""

    joint: int | None = None
    marker: str | None = None

    def __str__(self) -> str:
        if self.joint is not None:
            return f"joint {self.joint}"
        return f"marker {self.marker.upper()}" if self.marker else "whole arm"

    @property
    def keys(self) -> dict[str, int | str]:
        """The keys that a file states it by: those that are given."""
        stated = {"joint": self.joint, "marker": self.marker}
        return {key: value for key, value in stated.items() if value is not None}


# The whole arm, or the camera.
NOWHERE = Site()
