"""The film of the emulated bench shows what the simulated bench's pictures show."""

import numpy as np

from armtwin.scenarios.emulated_bench import emulated_setup
from armtwin.scenarios.emulated_film import Film
from armtwin.sim.bench import SimulatedBench
from armtwin.sim.sensor import IDEAL
from tests.support.worlds import flat_world, small_camera, with_effect


def test_film_and_simulated_bench_draw_one_arm() -> None:
    offset = {"x_mm": 4.0, "y_mm": 3.0, "body": 1}
    world = with_effect(small_camera(flat_world()), "marker_offset", offset, marker="b")
    film = Film(world, emulated_setup("/dev/null", "http://127.0.0.1/").servo_map, IDEAL, shadows=True)
    with SimulatedBench(world, sensor=IDEAL) as bench:
        still = bench.capture().image
    filmed = film.picture(set())
    film.close()
    np.testing.assert_array_equal(filmed, still)
