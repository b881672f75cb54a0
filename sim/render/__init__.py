"""Draw the bench as the webcam sees it.

    from armtwin.sim.render import LensRenderer, arm_parts, panel_parts, planar_arm_poses, robot_bodies_on_board

    parts = [*panel_parts(), *arm_parts([120.0, 121.7, 38.0, 6.73])]
    with LensRenderer(camera, parts, shadows=True) as renderer:
        poses = robot_bodies_on_board(planar_arm_poses(lengths, q), base_in_board_mm)  # {"base": (4, 4), "link1": ...}
        image = renderer.render(poses)                        # (H, W, 3) uint8, blue, green, red, linear in light
        linear = renderer.render_linear(poses, bumped_camera) # float32, 1 = full scale, for `armtwin.sim.sensor.expose`

Poses map body coordinates to the board frame, in mm. Bodies, named as in `models.mjcf`: `base`, `link1`, `end1` ...
(`arm_parts`), `board` (`chessboard_parts`), `gauge` (`gauge_parts`); a part without a body is
fixed in the board frame (`panel_parts`, `clutter_parts`). The discs' plane is z = 0 of their body. Pixels follow
OpenCV, as in `armtwin.models.camera`.
Worker processes are started by "spawn": an OpenGL context does not live through a fork.
"""

from armtwin.sim.render.arm_scene import arm_parts, marker_bodies, tip_in_last_link
from armtwin.sim.render.bench_scene import (
    GAUGE_LENGTHS_MM,
    chessboard_parts,
    clutter_parts,
    facing_camera,
    gauge_disc_radius_mm,
    gauge_parts,
    panel_parts,
)
from armtwin.sim.render.light import Light
from armtwin.sim.render.parts import Ink, Part
from armtwin.sim.render.poses import T_robot_board, planar_arm_poses, robot_bodies_on_board
from armtwin.sim.render.renderer import LensRenderer
from armtwin.sim.render.stickers import chessboard, disc

__all__ = [
    "GAUGE_LENGTHS_MM",
    "Ink",
    "LensRenderer",
    "Light",
    "Part",
    "T_robot_board",
    "arm_parts",
    "chessboard",
    "chessboard_parts",
    "clutter_parts",
    "disc",
    "facing_camera",
    "gauge_disc_radius_mm",
    "gauge_parts",
    "marker_bodies",
    "panel_parts",
    "planar_arm_poses",
    "robot_bodies_on_board",
    "tip_in_last_link",
]
