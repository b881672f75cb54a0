"""What is printed for a bench, true to size: the calibration board, the arm's stickers, a ruler to check the printer.

Every page carries a ruler of 100 mm, since printers like to fit pages to paper. PDF points are 1/72 inch.
"""

from __future__ import annotations

import io
from dataclasses import dataclass
from pathlib import Path

from reportlab.lib.colors import Color, black, white
from reportlab.lib.pagesizes import A4, LETTER, landscape
from reportlab.pdfgen.canvas import Canvas

from armtwin.models import atomic
from armtwin.models.errors import InputError, nearest, shown

POINTS_PER_MM = 72.0 / 25.4
PAPERS: dict[str, tuple[float, float]] = {"a4": landscape(A4), "letter": landscape(LETTER)}

# The paper's board (section 5.1): 7 rows and 10 columns of 23 mm squares, so 9 x 6 inner corners.
BOARD_COLUMNS, BOARD_ROWS, SQUARE_MM = 10, 7, 23.0
# The simulated arm's stickers: a red disc, 42 px wide in the paper's picture, on a black ground.
DISC_MM, GROUND_MM = 14.0, 21.0
# Red that the red channel sees as it sees white paper: only the ground is dark there.
RED = Color(0.85, 0.0, 0.0)
# A cross to prick a pin through. In white, which the red channel hardly tells from the disc: it moves no centre.
_CROSS_MM, _CROSS_LINE_MM = 3.0, 0.2
_STICKERS = (8, 4)  # columns, rows
_STICKER_PITCH_MM = 28.0
_RULER_MM = 100
_LONG_RULER_MM = 200
_MARGIN_MM = 10.0
_QUIET_MM = 8.0  # white between board and text


@dataclass(frozen=True)
class Page:
    """A page of the given size in mm, drawn on with mm from its lower left corner."""

    canvas: Canvas
    width_mm: float
    height_mm: float

    def rectangle(self, x: float, y: float, width: float, height: float) -> None:
        """Fill a rectangle."""
        self.canvas.rect(*(v * POINTS_PER_MM for v in (x, y, width, height)), stroke=0, fill=1)

    def disc(self, x: float, y: float, diameter: float, colour: Color) -> None:
        """Fill a disc."""
        self.canvas.setFillColor(colour)
        self.canvas.circle(x * POINTS_PER_MM, y * POINTS_PER_MM, 0.5 * diameter * POINTS_PER_MM, stroke=0, fill=1)
        self.canvas.setFillColor(black)

    def line(self, x0: float, y0: float, x1: float, y1: float) -> None:
        """Draw a hair line."""
        self.canvas.setLineWidth(0.1 * POINTS_PER_MM)
        self.canvas.line(*(v * POINTS_PER_MM for v in (x0, y0, x1, y1)))

    def cross(self, x: float, y: float, size: float, width: float, colour: Color) -> None:
        """Fill an upright cross of two bars."""
        self.canvas.setFillColor(colour)
        self.rectangle(x - 0.5 * size, y - 0.5 * width, size, width)
        self.rectangle(x - 0.5 * width, y - 0.5 * size, width, size)
        self.canvas.setFillColor(black)

    def text(self, x: float, y: float, words: str, size: float = 9.0) -> None:
        """Write a line."""
        self.canvas.setFont("Helvetica", size)
        self.canvas.drawString(x * POINTS_PER_MM, y * POINTS_PER_MM, words)


def targets_pdf(paper: str = "a4") -> bytes:
    """Return the PDF for a4 or letter paper; raises `InputError` for another."""
    if paper not in PAPERS:
        raise InputError(f"--paper: unknown '{shown(paper)}'{nearest(paper, PAPERS)}")
    out = io.BytesIO()
    size = PAPERS[paper]
    canvas = Canvas(out, pagesize=size, pageCompression=0, invariant=1)
    canvas.setTitle("armtwin targets")
    canvas.setViewerPreference("PrintScaling", "None")
    page = Page(canvas, size[0] / POINTS_PER_MM, size[1] / POINTS_PER_MM)
    for draw in (_board, _stickers, _ruler_page):
        draw(page)
        canvas.showPage()
    canvas.save()
    return out.getvalue()


def write_targets(path: Path, paper: str = "a4") -> None:
    """Write the PDF atomically."""
    atomic.write_bytes(path, targets_pdf(paper))


def board_corner_mm(page_width_mm: float, page_height_mm: float) -> tuple[float, float]:
    """Lower left corner of the board on its page, mm."""
    return 0.5 * (page_width_mm - BOARD_COLUMNS * SQUARE_MM), 0.5 * (page_height_mm - BOARD_ROWS * SQUARE_MM) + 4.0


def _board(page: Page) -> None:
    left, bottom = board_corner_mm(page.width_mm, page.height_mm)
    for column in range(BOARD_COLUMNS):
        for row in range(BOARD_ROWS):
            if (column + row) % 2 == 0:
                page.rectangle(left + column * SQUARE_MM, bottom + row * SQUARE_MM, SQUARE_MM, SQUARE_MM)
    _ruler(page, left, bottom - _QUIET_MM - 6.0, _RULER_MM)
    page.text(
        left + _RULER_MM + 8.0,
        bottom - _QUIET_MM - 5.0,
        f"armtwin board: {BOARD_COLUMNS} x {BOARD_ROWS} squares of {SQUARE_MM:g} mm "
        f"({BOARD_COLUMNS - 1}x{BOARD_ROWS - 1} corners). Print at 100 %, glue flat.",
        8.0,
    )


def _stickers(page: Page) -> None:
    columns, rows = _STICKERS
    left = 0.5 * (page.width_mm - (columns - 1) * _STICKER_PITCH_MM)
    top = page.height_mm - _MARGIN_MM - 0.5 * GROUND_MM - 6.0
    for column in range(columns):
        for row in range(rows):
            x, y = left + column * _STICKER_PITCH_MM, top - row * _STICKER_PITCH_MM
            page.disc(x, y, GROUND_MM, black)
            page.disc(x, y, DISC_MM, RED)
            page.cross(x, y, _CROSS_MM, _CROSS_LINE_MM, white)
    low = top - (rows - 1) * _STICKER_PITCH_MM - 0.5 * GROUND_MM
    _ruler(page, 0.5 * (page.width_mm - _RULER_MM), low - 20.0, _RULER_MM)
    page.text(
        _MARGIN_MM + 5.0,
        low - 30.0,
        f"armtwin stickers: discs of {DISC_MM:g} mm on {GROUND_MM:g} mm. Matt paper. Cut round the black ground, "
        "prick a pin through the cross, and put it on the axis of each joint (A, B, C) and on the tip (F).",
    )


def _ruler_page(page: Page) -> None:
    x, y = 0.5 * (page.width_mm - _LONG_RULER_MM), 0.5 * page.height_mm
    _ruler(page, x, y, _LONG_RULER_MM)
    lines = [
        "Check of the printer's scale",
        f"Hold a steel ruler against the scale above. If its {_LONG_RULER_MM} mm are not {_LONG_RULER_MM} mm to within "
        "half a millimetre,",
        "print again with scaling off (100 %, actual size). If the printer cannot, measure ten squares of the board "
        "and give a tenth",
        "of that as --square-mm to armtwin calibrate-camera.",
    ]
    for number, words in enumerate(lines):
        page.text(x, y - 15.0 - 6.0 * number, words, 12.0 if number == 0 else 9.0)


def _ruler(page: Page, x: float, y: float, length_mm: int) -> None:
    """Draw a scale with a tick a millimetre from (x, y) to the right."""
    page.line(x, y, x + length_mm, y)
    for tick in range(length_mm + 1):
        height = 5.0 if tick % 10 == 0 else 3.5 if tick % 5 == 0 else 2.0
        page.line(x + tick, y, x + tick, y + height)
        if tick % 10 == 0:
            page.text(x + tick - 1.5, y - 3.2, str(tick), 6.0)
