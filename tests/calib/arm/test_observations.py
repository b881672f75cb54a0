from dataclasses import replace

import numpy as np
import pytest

from armtwin.calib.arm.observations import fewest_poses, observe, rows_to_fit
from armtwin.models.errors import InputError


def test_held_out_trajectories_are_not_fitted(simulate):
    recording = simulate(held_out=("line",))
    assert set(recording.trajectory[rows_to_fit(recording)]) == {"circle_15", "circle_25"}


def test_a_named_trajectory_is_fitted_alone(simulate):
    recording = simulate()
    assert set(recording.trajectory[rows_to_fit(recording, ["circle_25"])]) == {"circle_25"}


def test_a_misspelt_trajectory_is_named_with_the_nearest_one(simulate):
    with pytest.raises(InputError, match=r"no trajectory 'circle15'; did you mean 'circle_15'\?"):
        rows_to_fit(simulate(), ["circle15"])


def test_holding_out_everything_is_refused(simulate):
    with pytest.raises(InputError, match="held_out names every trajectory"):
        rows_to_fit(simulate(held_out=("circle_15", "circle_25", "line")))


def test_only_seen_markers_are_observed(simulate):
    recording = simulate()
    recording.markers_px["b"][3] = np.nan
    recording.markers_px["f"][:] = np.nan
    seen = observe(recording, np.arange(len(recording)))
    assert seen.markers == ("a", "b", "c")
    assert len(seen.row) == 3 * len(recording) - 1
    assert np.isfinite(seen.pixels).all()


def test_all_markers_hidden_is_refused(simulate):
    recording = simulate()
    for pixels in recording.markers_px.values():
        pixels[:] = np.nan
    with pytest.raises(InputError, match="no marker is seen in any of the 150 poses"):
        observe(recording, np.arange(150))


@pytest.mark.parametrize("poses", [1, 2, 4])
def test_too_few_poses_are_refused_with_how_many_are_missing(simulate, poses):
    recording = simulate()
    with pytest.raises(InputError, match=f"{poses} poses? with .* needs at least 5: measure {5 - poses} more"):
        observe(recording, np.arange(poses))


def test_poses_without_a_marker_do_not_count(simulate):
    recording = simulate(markers="af")
    for pixels in recording.markers_px.values():
        pixels[4:] = np.nan
    with pytest.raises(InputError, match="4 poses with"):
        observe(recording, np.arange(20))


def test_the_fewest_poses_leave_the_tip_alone_more_numbers_than_unknowns(simulate):
    arm = replace(simulate().arm, name="chain", link_lengths_mm=np.ones(2) * 50)
    n = fewest_poses(arm)
    assert 2 * n > 2 * arm.n_joints + 2 >= 2 * (n - 1)
