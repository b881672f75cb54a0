"""Markers told apart by what the arm can reach: seen, hidden or ambiguous, and never silently swapped."""

from __future__ import annotations

from armtwin.calib.markers.disc import Array, Disc
from armtwin.calib.markers.explain import Explainer, Explanation
from armtwin.calib.markers.reading import MarkerReading, Status
from armtwin.models.arm import Arm
from armtwin.models.camera import Camera


def identify(
    discs: tuple[Disc, ...],
    arm: Arm,
    camera: Camera,
    plane_z_mm: float,
    q_cmd: Array | None = None,
    base_hint_mm: Array | None = None,
) -> MarkerReading:
    """Name the discs of one picture.

    Args:
        discs: what `detect` found.
        arm, camera, plane_z_mm: the nominal arm, and the camera that carries pixels to its plane, mm.
        q_cmd: (n,) commanded joint angles, rad. They break ties; alone they refuse no chain of the right lengths.
        base_hint_mm: (3,) where marker A lies in the board frame by other pictures, mm.

    """
    explainer = Explainer(discs, arm, camera, plane_z_mm, q_cmd, base_hint_mm)
    alike = explainer.explanations()
    seen: dict[str, Disc] = {}
    status: dict[str, Status] = {}
    messages: list[str] = []
    for marker, name in enumerate(arm.marker_names):
        choices = {e.discs[marker] for e in alike}
        only = choices.pop() if len(choices) == 1 else None
        if only is not None:
            status[name], seen[name] = "seen", discs[only]
            if not discs[only].coverage >= 0.0:
                continue
            if not discs[only].is_whole:
                messages.append(f"marker {name}: {discs[only].coverage:.0%} of its outline is seen")
        elif choices:
            status[name] = "ambiguous"
            messages.append(f"marker {name} is ambiguous: {_alternatives(alike, marker, discs)}")
        else:
            status[name] = "hidden"
            messages.append(f"marker {name} is hidden: {_why_hidden(explainer, alike[0], marker, arm)}")
    return MarkerReading(seen, status, tuple(messages))


def _alternatives(alike: list[Explanation], marker: int, discs: tuple[Disc, ...]) -> str:
    places = dict.fromkeys(e.discs[marker] for e in alike)
    names = [
        "it is hidden" if p is None else f"({discs[p].centre[0]:.0f}, {discs[p].centre[1]:.0f}) px" for p in places
    ]
    return " or ".join(names) + " explain the picture alike"


def _why_hidden(explainer: Explainer, explanation: Explanation, marker: int, arm: Arm) -> str:
    n_discs = len(explainer.places)
    seen = [i for i, disc in enumerate(explanation.discs) if disc is not None]
    if not seen:
        return f"{n_discs} disc{'s' * (n_discs != 1)} in the picture, none that the arm's links explain"
    nearest = min(seen, key=lambda i: abs(i - marker))
    low, high = explainer.reach_mm(min(nearest, marker), max(nearest, marker))
    return f"no disc left {low:.0f} to {high:.0f} mm from marker {arm.marker_names[nearest]} that fits"
