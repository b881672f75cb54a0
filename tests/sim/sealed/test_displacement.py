import numpy as np
import pytest

from armtwin.models.catalogue.sealed import Hidden
from armtwin.models.catalogue.site import Site
from armtwin.sim.sealed import bench_of, hide, moved_px
from tests.support.worlds import with_effect


@pytest.fixture(scope="module")
def stage():  # type: ignore[no-untyped-def]
    return bench_of(np.random.default_rng(3), ("gravity_sag",), n_poses=60, markers=("a", "b", "c", "f"))


def test_a_world_without_effects_does_not_move(stage) -> None:  # type: ignore[no-untyped-def]
    bench, scene = stage
    assert moved_px(scene, bench, 0) < 0.01


def test_geometry_takes_up_what_is_the_same_at_all_poses(stage) -> None:  # type: ignore[no-untyped-def]
    bench, scene = stage
    slipped = with_effect(bench, "joint_slip", {"jump_rad": 0.02, "from_sample": 0}, joint=2)
    assert moved_px(scene, slipped, 0, beyond_geometry=False) > 1.0
    assert moved_px(scene, slipped, 0) < 0.01


def test_an_event_counts_over_the_poses_that_it_touches(stage) -> None:  # type: ignore[no-untyped-def]
    bench, scene = stage
    apart = np.linalg.norm(scene.truth_px["b"][4:6] - scene.truth_px["c"][4:6], axis=1)
    assert moved_px(scene, _swapped(bench, [4, 5]), 0) == pytest.approx(np.sqrt(np.mean(apart**2)), rel=0.05)


def test_an_event_at_one_pose_alone_does_not_count(stage) -> None:  # type: ignore[no-untyped-def]
    bench, scene = stage
    assert moved_px(scene, _swapped(bench, [4]), 0) < 0.1  # of some hundred


def test_held_out_poses_do_not_count(stage) -> None:  # type: ignore[no-untyped-def]
    bench, scene = stage
    held = np.flatnonzero(np.isin(scene.plan.trajectory, scene.held_out)).tolist()
    assert moved_px(scene, _swapped(bench, held), 0, beyond_geometry=False) == 0.0


def _swapped(bench, samples: list[int]):  # type: ignore[no-untyped-def]
    return hide(bench, "marker_swap", Hidden(lambda a: {"samples": samples, "other": "c"}, 1, 1, Site(marker="b")), 1.0)


def test_a_joints_jump_moves_the_markers_beyond_it(stage) -> None:  # type: ignore[no-untyped-def]
    bench, scene = stage
    late = with_effect(bench, "joint_slip", {"jump_rad": 0.02, "from_sample": len(scene.plan) // 2}, joint=3)
    px_per_mm = 1438.6 / 485.0
    assert moved_px(scene, late, 0, beyond_geometry=False) == pytest.approx(0.02 * 38.6 * px_per_mm, rel=0.1)
