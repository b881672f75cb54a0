from dataclasses import replace

import numpy as np
import pytest

from armtwin.models.catalogue.site import Site
from armtwin.models.errors import InputError
from armtwin.models.world import Moment, checked_marker, joint_index, samples_of
from tests.support.worlds import flat_world


def test_marker_a_stands_in_the_arms_plane() -> None:
    np.testing.assert_allclose(flat_world().base_in_board_mm, [40.0, -33.0, -80.87])


def test_joints_count_from_one() -> None:
    assert joint_index(flat_world(), Site(1)) == 0


@pytest.mark.parametrize("joint", [None, 0, 4])
def test_a_joint_that_the_arm_does_not_have_is_refused(joint: int | None) -> None:
    with pytest.raises(InputError, match="needs a joint from 1 to 3"):
        joint_index(flat_world(), Site(joint))


def test_a_marker_that_the_arm_does_not_have_is_refused() -> None:
    with pytest.raises(InputError, match="'z'"):
        checked_marker(flat_world(), "z")


def test_samples_are_sorted() -> None:
    assert samples_of({"samples": [7.0, 3]}) == (3, 7)


def test_camera_motions_follow_one_another() -> None:
    def wider(camera, moment):  # type: ignore[no-untyped-def]
        return replace(camera, image_width=camera.image_width + moment.sample)

    world = flat_world().with_camera_motion(wider).with_camera_motion(wider)
    assert world.camera_at(Moment(10, 0.0, 0.0)).image_width == 1280 + 20
