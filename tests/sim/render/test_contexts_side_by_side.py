"""Renderers side by side: each draws in its own context, whatever is freed meanwhile and in whichever thread."""

from __future__ import annotations

import gc
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import overload

import numpy as np
import pytest
from numpy.typing import NDArray

from armtwin.models.errors import JobError
from armtwin.sim.render import LensRenderer, Part, arm_parts, panel_parts, planar_arm_poses, robot_bodies_on_board
from tests.sim.render.test_renderer import small_webcam

LENGTHS = [120.0, 121.7, 38.0, 6.73]
PARTS = [*panel_parts(), *arm_parts(LENGTHS)]
POSES = robot_bodies_on_board(planar_arm_poses(LENGTHS, [0.1, 0.2, 0.3]), np.array([-60.0, -50.0, -80.87]))


@pytest.fixture(scope="module")
def alone() -> NDArray[np.uint8]:
    """Return the picture of a renderer that has the process for itself."""
    with LensRenderer(small_webcam(), PARTS, shadows=True) as renderer:
        return renderer.render(POSES)


class Interrupted(Sequence[Part]):
    """The parts of a scene; something happens each time they are looked through, once the context stands."""

    def __init__(self, happen: Callable[[], None]) -> None:
        self._happen = happen

    @overload
    def __getitem__(self, index: int) -> Part: ...
    @overload
    def __getitem__(self, index: slice) -> Sequence[Part]: ...
    def __getitem__(self, index: int | slice) -> Part | Sequence[Part]:
        return PARTS[index]

    def __len__(self) -> int:
        return len(PARTS)

    def __iter__(self) -> Iterator[Part]:
        self._happen()
        return iter(PARTS)


def left_in_a_cycle() -> None:
    """Leave a renderer that only the garbage collector finds."""
    renderer = LensRenderer(small_webcam(), PARTS)
    renderer.render(POSES)
    renderer.itself = renderer  # type: ignore[attr-defined]


@pytest.mark.parametrize("closed", [True, False], ids=["closed", "forgotten"])
def test_a_renderer_freed_while_another_is_built_takes_nothing_from_it(closed: bool, alone: NDArray[np.uint8]) -> None:
    old = [LensRenderer(small_webcam(), PARTS) for _ in range(12)]
    if closed:
        [renderer.close() for renderer in old]

    def free_one() -> None:
        if old:
            old.pop()

    with LensRenderer(small_webcam(), Interrupted(free_one), shadows=True) as built:
        assert len(old) < 6, "some were to be freed after the new one's context was made"
        np.testing.assert_array_equal(built.render(POSES), alone)


def test_a_renderer_freed_by_another_thread_takes_nothing_from_this_one(alone: NDArray[np.uint8]) -> None:
    with ThreadPoolExecutor(1) as elsewhere, LensRenderer(small_webcam(), PARTS, shadows=True) as renderer:
        renderer.render(POSES)
        left_in_a_cycle()
        elsewhere.submit(gc.collect).result()
        np.testing.assert_array_equal(renderer.render(POSES), alone)


def test_a_renderer_may_be_built_in_one_thread_used_in_another_and_closed_in_a_third(alone: NDArray[np.uint8]) -> None:
    with ThreadPoolExecutor(1) as first, ThreadPoolExecutor(1) as second:
        renderer = first.submit(LensRenderer, small_webcam(), PARTS, shadows=True).result()
        np.testing.assert_array_equal(second.submit(renderer.render, POSES).result(), alone)
    renderer.close()


def test_two_threads_draw_at_the_same_time_each_with_its_own(alone: NDArray[np.uint8]) -> None:
    def draw() -> list[NDArray[np.uint8]]:
        with LensRenderer(small_webcam(), PARTS, shadows=True) as renderer:
            return [renderer.render(POSES) for _ in range(4)]

    with ThreadPoolExecutor(2) as pool:
        for pictures in [task.result() for task in [pool.submit(draw), pool.submit(draw)]]:
            for picture in pictures:
                np.testing.assert_array_equal(picture, alone)


def test_what_was_current_is_current_again_after_a_frame() -> None:
    with LensRenderer(small_webcam(), PARTS) as outer, LensRenderer(small_webcam(), PARTS) as inner:
        from OpenGL import GL

        with outer._context.current():
            GL.glClearColor(0.25, 0.5, 0.75, 1.0)
            inner.render(POSES)
            np.testing.assert_allclose(GL.glGetFloatv(GL.GL_COLOR_CLEAR_VALUE), [0.25, 0.5, 0.75, 1.0])


def test_a_closed_renderer_says_so() -> None:
    renderer = LensRenderer(small_webcam(), PARTS)
    renderer.close()
    renderer.close()
    with pytest.raises(JobError, match="a closed renderer draws nothing"):
        renderer.render(POSES)


@pytest.mark.parametrize("supersampling", [1, 2, 3])
def test_samples_averaged_by_the_card_and_by_the_processor_give_the_same_bytes(supersampling: int) -> None:
    camera = small_webcam()
    with LensRenderer(camera, PARTS, supersampling=supersampling) as renderer:
        renderer.render(POSES)
        from armtwin.sim.render.averaging import AverageOnCard, AverageOnProcessor
        from armtwin.sim.render.frame_buffer import Box

        with renderer._context.current():
            by_card = AverageOnCard(camera.image_width, camera.image_height)
            for box in (Box(0, 0, camera.image_width, camera.image_height), Box(101, 57, 333, 258)):
                drawn = renderer._painter._frame
                seen, expected = by_card.of(drawn, box)[..., :3], AverageOnProcessor().of(drawn, box)[..., :3]
                assert np.ptp(expected) > 100
                np.testing.assert_array_equal(seen, expected)
            by_card.delete()
