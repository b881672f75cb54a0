"""What the webcam sees, and how the markers are found in it (Figure 3)."""

from __future__ import annotations

import cv2
import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from armtwin.calib.markers import identify, paper_stages
from armtwin.calib.markers.detect import detect
from armtwin.models.recordings.recording import Recording
from armtwin.scenarios.report.data import RunData
from armtwin.scenarios.report.section import Section, fold, gallery, picture, prose, table
from armtwin.scenarios.runner.frames import read_frame

Image = NDArray[np.uint8]

# BGR of the report's colours for armtwin's and the paper's detector.
_OURS, _PAPERS, _HALO = (178, 114, 0), (167, 121, 204), (255, 255, 255)
# Sub-pixel drawing: OpenCV takes coordinates in 1/2^4 px.
_SHIFT = 4
_CROP_PX = 44
_ZOOM = 8


def bench_section(run: RunData) -> Section:
    """Show a frame with the detections drawn, each marker enlarged, and the stages of the paper's chain."""
    recording = run.recording("before")
    row = int(run.results["figures"]["3"]["sample"])
    image = read_frame(run.out / "recordings" / "before" / "frames", row)
    return Section(
        slug="bench",
        title="What the webcam sees",
        lead=(
            "The arm is moved by MuJoCo and drawn through the measured lens of the paper's webcam, then blurred and "
            "made noisy as a sensor would. Everything that follows is learned from such pictures alone."
        ),
        blocks=(
            picture(
                _with_detections(image, recording, row),
                f"Sample {row} of the first trajectory. Blue: outline points and centres found by armtwin's sub-pixel "
                "detector. Pink: circles found by the paper's filter chain (Hough transform).",
            ),
            gallery(
                _close_ups(image, recording, row),
                f"The markers, {_ZOOM} times enlarged. The Hough circle sits on the pixel grid; the ellipse through "
                "sub-pixel edge points does not.",
                columns=4,
            ),
            _unseen(run),
            fold(
                "Figure 3: the stages of the paper's detector, one by one",
                [
                    gallery(
                        _stages(image),
                        "Section 3.2: red channel, smoothing, derivatives, threshold, opening, Hough.",
                    )
                ],
            ),
        ),
    )


def _with_detections(image: Image, recording: Recording, row: int) -> Image:
    shown = image.copy()
    _draw(shown, image, recording, row, 0.0, 0.0, 1.0)
    return shown


def _close_ups(image: Image, recording: Recording, row: int) -> list[tuple[str, Image]]:
    pictures = []
    for name in recording.arm.marker_names:
        centre = recording.markers_px[name][row]
        if not np.isfinite(centre).all():
            continue
        half = _CROP_PX // 2
        left = int(np.clip(round(centre[0]) - half, 0, image.shape[1] - _CROP_PX))
        top = int(np.clip(round(centre[1]) - half, 0, image.shape[0] - _CROP_PX))
        crop = image[top : top + _CROP_PX, left : left + _CROP_PX]
        large = np.asarray(cv2.resize(crop, None, fx=_ZOOM, fy=_ZOOM, interpolation=cv2.INTER_NEAREST), np.uint8)
        _draw(large, image, recording, row, left, top, float(_ZOOM))
        pictures.append((f"{name.upper()}: ({centre[0]:.2f}, {centre[1]:.2f}) px", large))
    return pictures


def _draw(shown: Image, image: Image, recording: Recording, row: int, left: float, top: float, zoom: float) -> None:
    """Draw what both detectors found in `image` onto `shown`, a part of it enlarged by `zoom`."""

    def at(u: float, v: float) -> tuple[int, int]:
        scale = zoom * (1 << _SHIFT)
        x, y = (u - left + 0.5) * scale - 0.5 * (1 << _SHIFT), (v - top + 0.5) * scale - 0.5 * (1 << _SHIFT)
        return round(x), round(y)

    for u, v, radius in paper_stages(image).circles:
        cv2.circle(shown, at(u, v), round(radius * zoom * (1 << _SHIFT)), _PAPERS, 2, cv2.LINE_AA, _SHIFT)
        cv2.drawMarker(shown, _whole(at(u, v)), _PAPERS, cv2.MARKER_TILTED_CROSS, 12, 2, cv2.LINE_AA)
    assert recording.camera is not None
    assert recording.arm_plane_z_mm is not None
    discs = detect(image, "subpixel", recording.camera, recording.arm_plane_z_mm)
    found = identify(discs, recording.arm, recording.camera, recording.arm_plane_z_mm, recording.q_cmd[row]).discs
    for name, disc in found.items():
        dot = max(1.0, 0.35 * zoom)
        for colour, size in ((_HALO, dot + 1.0), (_OURS, dot)):
            for u, v in disc.edges:
                cv2.circle(shown, at(u, v), round(size * (1 << _SHIFT)), colour, -1, cv2.LINE_AA, _SHIFT)
        for colour, width in ((_HALO, 5), (_OURS, 2)):
            cv2.drawMarker(shown, _whole(at(*disc.centre)), colour, cv2.MARKER_CROSS, 16, width, cv2.LINE_AA)
        if zoom == 1.0:
            u, v = _whole(at(*disc.centre))
            cv2.putText(shown, name.upper(), (u + 30, v + 10), cv2.FONT_HERSHEY_SIMPLEX, 1.0, _OURS, 2, cv2.LINE_AA)


def _whole(point: tuple[int, int]) -> tuple[int, int]:
    return point[0] >> _SHIFT, point[1] >> _SHIFT


def _stages(image: Image) -> list[tuple[str, Image]]:
    stages = paper_stages(image)
    last = np.asarray(cv2.cvtColor(stages.opened, cv2.COLOR_GRAY2BGR), np.uint8)
    for u, v, radius in stages.circles:
        cv2.circle(last, (round(u), round(v)), round(radius), _PAPERS, 3, cv2.LINE_AA)
    pictures = [
        ("(a) red channel", stages.red),
        ("(b) smoothed", stages.smooth),
        ("(c) derivative in u", stages.gradient_u),
        ("(d) derivative in v", stages.gradient_v),
        ("(e) gradient, binary", stages.binary),
        ("(f) opened, with Hough circles", last),
    ]
    return [
        (name, np.asarray(cv2.resize(p, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA), np.uint8))
        for name, p in pictures
    ]


def _unseen(run: RunData) -> Markup:
    markers = run.results["markers"]
    lines = [line for found in markers.values() for line in found["subpixel"]["messages"]]
    if not lines:
        return prose("Every marker was seen in every frame.")
    rows = [
        [f"{name}, {method}", *(str(count) for count in found["unseen"].values())]
        for name, both in markers.items()
        for method, found in both.items()
    ]
    names = [name.upper() for name in next(iter(markers.values()))["subpixel"]["unseen"]]
    shown = "\n".join(lines[:12]) + (f"\n… and {len(lines) - 12} more" if len(lines) > 12 else "")
    return fold(
        f"{len(lines)} sightings were refused or missed",
        [
            table(
                ["frames in which a marker was not seen", *names],
                rows,
                "Nothing is guessed: an unseen marker stays empty in samples.csv.",
            ),
            prose(shown),
        ],
    )
