import numpy as np
import pytest

from armtwin.models.catalogue.registry import catalogue
from tests.support.uncatalogued import UNCATALOGUED, draw_uncatalogued


def test_none_of_them_is_in_the_catalogue() -> None:
    assert not set(UNCATALOGUED) & set(catalogue())


@pytest.mark.parametrize("name", UNCATALOGUED)
def test_each_moves_the_markers_well_beyond_the_noise(name: str) -> None:
    sealed = draw_uncatalogued(np.random.default_rng(1), name, "medium", n_poses=60)
    assert sealed.truth["effects"][0]["moved_noises"] >= 6.0
    assert len(sealed.recording) == sealed.truth["n_poses"]
