"""A sticker off its joint's axis."""

import numpy as np
import pytest

from armtwin.models.catalogue.predict import marker_points
from armtwin.models.catalogue.registry import Site, effect_named
from tests.support.contexts import active, context_of, drawn


def moved(marker: str, body: float) -> np.ndarray:
    context = context_of()
    offset = active("marker_offset", [2.0, 1.0, body], marker=marker)
    return (
        marker_points(context, drawn(context), context.q_cmd, (offset,))
        - marker_points(context, drawn(context), context.q_cmd)
    )[..., :2]


@pytest.mark.parametrize("body", [0.0, 1.0])
@pytest.mark.parametrize("marker", ["a", "b", "c"])
def test_only_that_sticker_is_off_and_always_by_the_same_distance(marker: str, body: float) -> None:
    off = np.linalg.norm(moved(marker, body), axis=-1)
    column = "abcf".index(marker)
    np.testing.assert_allclose(off[:, column], np.hypot(2.0, 1.0))
    assert not np.delete(off, column, axis=1).any()


@pytest.mark.parametrize(("body", "link"), [(0.0, 0), (1.0, 1)])
def test_the_offset_turns_with_the_link_that_carries_the_sticker(body: float, link: int) -> None:
    context = context_of()
    shift = moved("b", body)[:, 1] @ [1.0, 1j]
    np.testing.assert_allclose(shift / context.directions(context.q_cmd)[:, link], 2.0 + 1.0j)


def test_a_sticker_of_the_base_stays_where_it_is() -> None:
    np.testing.assert_allclose(moved("a", 0.0)[:, 0], [[2.0, 1.0]] * 40)


def test_the_tip_s_sticker_is_the_last_link_itself() -> None:
    assert effect_named("marker_offset").applies(context_of(), Site(marker="f")) is not None
    assert effect_named("marker_offset").applies(context_of(), Site(marker="b")) is None


def test_of_one_marker_alone_nothing_can_be_told() -> None:
    assert effect_named("marker_offset").applies(context_of(markers=("b",)), Site(marker="b")) is not None
