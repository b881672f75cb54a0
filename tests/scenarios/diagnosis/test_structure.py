"""Of every way to plot a remainder, the most telling one comes first."""

import numpy as np
import pytest

from armtwin.scenarios.diagnosis.structure import Ordinate, groups_of, share_of_groups

N = 120
ORDER = Ordinate("order", "pose", np.arange(N, dtype=float))


def noise(seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).standard_normal(N)


@pytest.mark.parametrize("seed", range(5))
def test_of_noise_hardly_any_share_follows_anything(seed: int) -> None:
    assert share_of_groups(ORDER, noise(seed)) < 0.2


def test_what_bends_with_the_ordinate_follows_it() -> None:
    bent = np.sin(np.linspace(0.0, np.pi, N))
    assert share_of_groups(ORDER, bent) > 0.9
    assert 0.5 < share_of_groups(ORDER, 3.0 * bent + noise()) < 0.9


def test_a_jump_between_two_directions_is_the_share_between_them() -> None:
    side = np.where(np.arange(N) % 2, 1.0, -1.0)
    direction = Ordinate("direction of approach", "joint 1 was approached", side, is_direction=True)
    assert share_of_groups(direction, side + 1e-3 * noise()) == pytest.approx(1.0, abs=1e-4)
    assert share_of_groups(ORDER, side + 1e-3 * noise()) < 0.2


def test_poses_of_which_nothing_was_seen_are_left_out() -> None:
    bent = np.sin(np.linspace(0.0, np.pi, N))
    bent[::3] = np.nan
    assert share_of_groups(ORDER, bent) > 0.9


def test_groups_hold_every_seen_pose_once_in_ascending_order() -> None:
    values = noise()
    groups = groups_of(Ordinate("angle of joint 1", "angle", values), np.arange(N) != 7)
    rows = np.concatenate(groups)
    assert sorted(rows) == [row for row in range(N) if row != 7]
    assert (np.diff(values[rows]) >= 0).all()


def test_too_few_poses_show_no_share() -> None:
    few = Ordinate("order", "pose", np.arange(5.0))
    assert share_of_groups(few, np.arange(5.0)) == 0.0
