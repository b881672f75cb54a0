"""What a renderer promises its user: the same frame by whichever way it is drawn, no unset pixel, clear errors."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from armtwin.models.camera import Camera, project
from armtwin.models.errors import InputError
from armtwin.sim.render import (
    LensRenderer,
    Light,
    Part,
    arm_parts,
    clutter_parts,
    panel_parts,
    planar_arm_poses,
    robot_bodies_on_board,
)
from armtwin.sim.render.bench_scene import PANEL
from armtwin.sim.render.solids import box
from tests.sim.render.cameras import webcam

Array = NDArray[np.float64]
LENGTHS = [120.0, 121.7, 38.0, 6.73]
BASE = np.array([-60.0, -50.0, -80.87])
MAGENTA = (1.0, 0.0, 1.0)


def small_webcam(tilt_deg: float = 0.0) -> Camera:
    camera = webcam(tilt_deg)
    return replace(camera, image_width=640, image_height=360, K=np.diag([0.5, 0.5, 1.0]) @ camera.K)


def scene() -> list[Part]:
    return [*panel_parts(), *clutter_parts(BASE), *arm_parts(LENGTHS)]


def arm_at(*q: float) -> dict[str, Array]:
    return robot_bodies_on_board(planar_arm_poses(LENGTHS, q), BASE)


def bumped(camera: Camera, by_mm: float) -> Camera:
    return camera.moved(np.eye(3), np.array([by_mm, 0.0, 0.0]))


@pytest.mark.parametrize("shadows", [False, True])
def test_a_frame_over_the_kept_background_is_the_frame_drawn_whole(shadows: bool) -> None:
    camera = small_webcam(10.0)
    with (
        LensRenderer(camera, scene(), shadows=shadows) as kept,
        LensRenderer(camera, scene(), shadows=shadows) as whole,
    ):
        kept.render(arm_at(0.0, 0.0, 0.0))
        for step in range(6):
            poses = arm_at(0.5 * step - 1.5, 0.2 * step, -0.4 * step)
            whole.render(poses, bumped(camera, 1.0))  # whose next camera is a new one, for which nothing is kept
            assert np.array_equal(kept.render(poses), whole.render(poses, camera))


@pytest.mark.parametrize("tilt_deg", [0.0, 25.0])
@pytest.mark.parametrize("supersampling", [1, 2, 3])
def test_no_pixel_is_left_unset(tilt_deg: float, supersampling: int) -> None:
    camera = small_webcam(tilt_deg)
    with LensRenderer(camera, scene(), supersampling=supersampling, background=MAGENTA, shadows=True) as renderer:
        for image in (renderer.render(arm_at(0.1, 0.2, 0.3)), renderer.render(arm_at(0.1, 0.2, 0.3))):
            # Nothing of the scene has more blue than twice its green and as much red: magenta mixed in would.
            blue, green, red = (image[..., c].astype(int) for c in range(3))
            assert not np.any((blue > 2 * green + 40) & (red > 2 * green + 40))


def test_the_panel_has_one_colour_up_to_the_border() -> None:
    with LensRenderer(small_webcam(), panel_parts()) as renderer:
        image = renderer.render({})
    assert np.array_equal(image, np.broadcast_to(image[180, 320], image.shape))


def test_nothing_beyond_the_fold_of_the_lens_comes_back_into_the_picture() -> None:
    camera = webcam()
    angles = np.linspace(0.0, 2.0 * np.pi, 60, endpoint=False)
    solids, centres = [], []
    for radius in (0.75, 0.82, 0.9, 1.1):
        for x, y in 485.0 * radius * np.stack([np.cos(angles), np.sin(angles)], axis=1):
            solids.append(Part("far", box((x - 4.0, y - 4.0, -8.0), (x + 4.0, y + 4.0, 0.0)), MAGENTA))
            centres.append((x, y, 0.0))
    pixels = project(camera, np.array(centres))
    inside = np.all((pixels >= 0.0) & (pixels < [1280, 720]), axis=1)
    assert inside.sum() > 50  # the polynomial alone would bring them back
    with LensRenderer(camera, [*panel_parts(), *solids]) as renderer:
        image = renderer.render({})
    assert np.array_equal(image, np.broadcast_to(image[360, 640], image.shape))


def test_colours_are_blue_green_red_and_linear_in_light() -> None:
    red = Part("red", box((-300.0, -300.0, 0.0), (300.0, 300.0, 5.0)), (0.8, 0.4, 0.1))
    with LensRenderer(small_webcam(), [red]) as renderer:
        pixel = renderer.render({})[180, 320].astype(float)
        linear = renderer.render_linear({})[180, 320]
    assert pixel[1] / pixel[2] == pytest.approx(0.5, abs=0.01)
    assert pixel[0] / pixel[2] == pytest.approx(0.125, abs=0.01)
    assert linear.dtype == np.float32
    assert linear * 255.0 == pytest.approx(pixel, abs=1e-4)


def test_a_changed_focal_length_takes_effect_at_once() -> None:
    camera = small_webcam()
    longer = replace(camera, K=np.diag([1.1, 1.1, 1.0]) @ camera.K)
    with LensRenderer(camera, scene()) as one, LensRenderer(longer, scene()) as other:
        one.render(arm_at(0.0, 0.0, 0.0))
        assert np.array_equal(one.render(arm_at(0.0, 0.0, 0.0), longer), other.render(arm_at(0.0, 0.0, 0.0)))


def test_shadows_darken_only_the_panel() -> None:
    camera = small_webcam()
    poses = arm_at(0.2, -0.1, 0.3)
    with LensRenderer(camera, scene()) as lit, LensRenderer(camera, scene(), shadows=True) as shaded:
        without, with_shadow = lit.render(poses), shaded.render(poses)
    with LensRenderer(camera, panel_parts()) as bare:
        panel = bare.render({})[180, 320].astype(int)
    darker = np.any(without != with_shadow, axis=2)
    assert 0.03 < darker.mean() < 0.5
    assert np.all(with_shadow <= without)
    # Where a pixel shows nothing but panel, it lies between lit and lit by ambient light alone, and mostly at either.
    light, paint = Light(), np.array(PANEL[::-1])
    shade = np.round(255.0 * paint * light.ambient)
    only_panel = np.all(without == panel, axis=2)
    seen = with_shadow[only_panel]
    assert np.all((seen >= shade - 1) & (seen <= panel))
    between = np.any((seen > shade + 1) & (seen < panel), axis=1)
    assert between.mean() < 0.05
    assert np.all(only_panel[darker].mean() > 0.9)


def test_closing_a_renderer_leaves_others_and_mujoco_alive() -> None:
    script = """
import os
os.environ["MUJOCO_GL"] = "egl"
import numpy as np, mujoco
from armtwin.sim.render import LensRenderer, panel_parts
from tests.sim.render.cameras import webcam
model = mujoco.MjModel.from_xml_string("<mujoco><worldbody><light/><geom size='1'/></worldbody></mujoco>")
data = mujoco.MjData(model)
mujoco.mj_forward(model, data)
other = mujoco.Renderer(model, 60, 80)
def picture():
    other.update_scene(data)
    return other.render()
first = LensRenderer(webcam(), panel_parts())
second = LensRenderer(webcam(), panel_parts())
before, theirs = second.render({}), picture()
first.render({})
first.close()
first.close()
assert np.array_equal(second.render({}), before)
assert np.array_equal(picture(), theirs)
assert np.array_equal(second.render({}), before)
second.close()
assert np.array_equal(picture(), theirs)
other.close()
print("alive")
"""
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, cwd=Path(__file__).parents[3])
    assert run.stdout == "alive\n", run.stderr


def test_a_body_without_a_pose_is_named() -> None:
    poses = arm_at(0.0, 0.0, 0.0)
    del poses["link2"]
    with LensRenderer(small_webcam(), scene()) as renderer, pytest.raises(InputError, match="link2"):
        renderer.render(poses)


def test_a_camera_of_another_picture_size_is_refused() -> None:
    with LensRenderer(small_webcam(), panel_parts()) as renderer, pytest.raises(InputError, match="1280x720"):
        renderer.render({}, webcam())


def test_shadows_need_a_part_to_fall_on() -> None:
    with pytest.raises(InputError, match="backdrop"):
        LensRenderer(small_webcam(), arm_parts(LENGTHS), shadows=True)


def test_too_many_bodies_are_refused() -> None:
    solid = box((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))
    with pytest.raises(InputError, match="at most 31"):
        LensRenderer(small_webcam(), [Part(f"p{k}", solid, MAGENTA, f"b{k}") for k in range(32)])
