import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from armtwin.models.trajectories import circle, line, paper_trajectories

point = st.tuples(st.floats(-200, 200), st.floats(-200, 200))


@given(point, st.floats(0.1, 100), st.integers(3, 100))
def test_a_circle_keeps_its_radius_and_spaces_its_points_evenly(centre, radius, n):
    poses = circle(centre, radius, n)
    assert poses.shape == (n, 3)
    np.testing.assert_allclose(np.linalg.norm(poses[:, :2] - centre, axis=1), radius, atol=1e-9)
    steps = np.linalg.norm(np.diff(poses[:, :2], axis=0, append=poses[:1, :2]), axis=1)
    np.testing.assert_allclose(steps, steps[0], atol=1e-9)


@given(point, point, st.integers(2, 100))
def test_a_line_has_both_ends_and_even_steps(start, end, n):
    poses = line(start, end, n)
    np.testing.assert_allclose(poses[[0, -1], :2], [start, end])
    np.testing.assert_allclose(
        np.diff(poses[:, :2], axis=0), np.diff(poses[:2, :2], axis=0).repeat(n - 1, 0), atol=1e-9
    )


def test_the_papers_trajectories_are_those_of_section_4():
    paper = paper_trajectories()
    assert list(paper) == ["circle_15", "circle_25", "line"]
    for radius in (15.0, 25.0):
        around = paper[f"circle_{radius:.0f}"]
        np.testing.assert_allclose(np.linalg.norm(around[:, :2] - [-130.0, 40.0], axis=1), radius)
    np.testing.assert_allclose(paper["line"][[0, -1], :2], [[-145.0, 25.0], [-115.0, 45.0]])
    for poses in paper.values():
        assert poses.shape == (50, 3)
        np.testing.assert_array_equal(poses[:, 2], np.pi)
