"""What stands around the arm, and the objects that are held before the camera."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from armtwin.models.errors import InputError
from armtwin.sim.render.parts import Colour, Part
from armtwin.sim.render.solids import EDGE_MM, box, circle, extrusion, grid, plate, steps, translation
from armtwin.sim.render.stickers import BLACK, WHITE, chessboard, disc

Array = NDArray[np.float64]

PANEL: Colour = (0.60, 0.59, 0.55)  # pale laminate
WOOD: Colour = (0.42, 0.27, 0.15)
CIRCUIT_BOARD: Colour = (0.012, 0.22, 0.26)
CONNECTOR: Colour = (0.04, 0.04, 0.04)
METAL: Colour = (0.45, 0.45, 0.47)
SCREW: Colour = (0.20, 0.20, 0.21)

# The paper's board: 7 rows and 10 columns of 23 mm squares, 9 x 6 inner corners (section 5.1).
BOARD_COLUMNS, BOARD_ROWS, SQUARE_MM = 10, 7, 23.0
# Mitutoyo's blocks of Table 3, mm.
GAUGE_LENGTHS_MM = (40.0, 30.0, 10.0, 5.0)

# z_board of the panel: the calibration board, 4 mm thick, lies on it with its squares in the plane z_board = 0.
PANEL_Z_MM = 4.5
# The panel's own edges lie outside the picture, so its faces may be large.
_PANEL_EDGE_MM = 25.0


def panel_parts() -> list[Part]:
    """Build the panel behind the arm, fixed in the board frame; shadows fall on it. A webcam sees nothing beyond it."""
    panel = grid(steps(-600.0, 800.0, _PANEL_EDGE_MM), steps(-500.0, 600.0, _PANEL_EDGE_MM), PANEL_Z_MM)
    return [Part("panel", panel, PANEL, backdrop=True)]


def clutter_parts(base_in_board_mm: Array) -> list[Part]:
    """Build what else is on the panel, placed from the robot's origin (3,) mm: a rail, the Arduino, screws."""
    x, y = float(base_in_board_mm[0]), float(base_in_board_mm[1])
    z = PANEL_Z_MM
    board_low, board_high = (x - 130.0, y - 45.0), (x - 61.4, y + 8.4)  # an Uno measures 68.6 x 53.4 mm
    parts = [
        Part("rail", box((x - 500.0, y - 90.0, z - 22.0), (x + 500.0, y - 60.0, z)), WOOD),
        Part("uno", box((*board_low, z - 10.0), (*board_high, z - 8.4)), CIRCUIT_BOARD),
        Part(
            "uno usb",
            box(
                (board_high[0] - 10.0, board_high[1] - 22.0, z - 21.0),
                (board_high[0] + 6.0, board_high[1] - 10.0, z - 10.0),
            ),
            METAL,
        ),
        Part(
            "uno header",
            box(
                (board_low[0] + 4.0, board_high[1] - 4.0, z - 18.5),
                (board_high[0] - 18.0, board_high[1] - 1.5, z - 10.0),
            ),
            CONNECTOR,
        ),
        Part(
            "uno chip",
            box(
                (board_low[0] + 8.0, board_low[1] + 12.0, z - 14.0),
                (board_low[0] + 43.0, board_low[1] + 19.0, z - 10.0),
            ),
            CONNECTOR,
        ),
    ]
    for number, (dx, dy) in enumerate([(-150.0, 140.0), (240.0, 140.0), (150.0, 20.0)]):
        head = extrusion(circle(4.0), 0.0, 2.5)
        parts.append(Part(f"screw {number}", head, SCREW).on(None, facing_camera(x + dx, y + dy, z)))
    return parts


def chessboard_parts(
    columns: int = BOARD_COLUMNS, rows: int = BOARD_ROWS, square_mm: float = SQUARE_MM, margin_mm: float = SQUARE_MM
) -> list[Part]:
    """Build the calibration board on body `board`: squares, white margin, and a plate behind them, 4 mm in all.

    Its frame is OpenCV's: origin on the first inner corner, x along the columns, y along the rows, z away from the side
    that is printed.
    """
    if columns < 3 or rows < 3:
        raise InputError(f"a chessboard needs at least 3 x 3 squares; {columns} x {rows} were asked for")
    if not (square_mm > 0.0 and margin_mm > 0.0):
        raise InputError(
            f"a chessboard's squares and margin must be positive; {square_mm} and {margin_mm} mm were given"
        )
    low = -square_mm - margin_mm
    high = (columns - 1) * square_mm + margin_mm, (rows - 1) * square_mm + margin_mm
    backing = plate((low, low, 0.5), (*high, 4.0), 2.0 * EDGE_MM)
    return [
        Part("board backing", backing, WHITE, "board"),
        chessboard("board squares", columns, rows, square_mm, margin_mm).on("board"),
    ]


def gauge_disc_radius_mm(length_mm: float) -> float:
    """Radius of the targets on a gauge: 6 mm, or less where two would touch."""
    return min(6.0, 0.4 * length_mm)


def gauge_parts(length_mm: float) -> list[Part]:
    """Build a length gauge on body `gauge`: a steel block with two disc targets, their centres `length_mm` apart.

    The paper measures its gauge blocks "by a process similar to Figure 3", that is between circles, so the simulated
    gauge shows circles whose distance is the known length. The frame's origin is half way between them, x along the
    length, z towards the camera; the targets are in the plane z = 0.
    """
    if not length_mm > 0.0:
        raise InputError(f"a gauge's length must be positive; {length_mm} mm was given")
    radius = gauge_disc_radius_mm(length_mm)
    ground = min(1.35 * radius, 0.5 * length_mm)
    half = 0.5 * length_mm + radius + 3.0
    block = box((-half, -radius - 6.0, -9.5), (half, radius + 6.0, -0.5))
    label = box((-half + 1.0, -radius - 2.0, -0.5), (half - 1.0, radius + 2.0, -0.2))
    return [
        Part("gauge block", block, METAL, "gauge"),
        Part("gauge label", label, BLACK, "gauge"),
        disc("gauge left", radius, ground, (-0.5 * length_mm, 0.0, 0.0)).on("gauge"),
        disc("gauge right", radius, ground, (0.5 * length_mm, 0.0, 0.0)).on("gauge"),
    ]


def facing_camera(x_mm: float, y_mm: float, z_mm: float) -> Array:
    """(4, 4) pose in the board frame of a body whose z looks towards the camera and whose y points up."""
    return translation(x_mm, y_mm, z_mm) @ np.diag([-1.0, 1.0, -1.0, 1.0])
