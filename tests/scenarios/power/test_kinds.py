"""Forms of a fault by their kinds, on the real draws of effects that have several."""

import numpy as np
import pytest

from armtwin.models.arm import nominal_arm
from armtwin.models.catalogue.site import NOWHERE, Site
from armtwin.models.plan import paper_plan
from armtwin.scenarios.power.arms import Arms
from armtwin.scenarios.power.kinds import drawn_kinds
from armtwin.scenarios.power.setting import Setting


@pytest.fixture(scope="module")
def arms() -> Arms:
    return Arms(Setting(paper_plan(nominal_arm()), 0.1, ("a", "b", "c", "f")), 0)


def test_a_load_from_the_first_pose_on_weighs_as_often_as_it_is_hidden(arms: Arms) -> None:
    _, scene = arms.bench(0, "payload")
    kinds = drawn_kinds(np.random.default_rng(1), scene, "payload", NOWHERE, 3)
    at_once = sum(weight for hidden, weight in kinds if hidden.parameters(0.1)["from_sample"] == 0)
    assert sum(weight for _, weight in kinds) == pytest.approx(1.0)
    assert at_once == pytest.approx(0.3, abs=0.15)


def test_a_fault_of_one_kind_comes_in_as_many_forms_as_are_asked_for(arms: Arms) -> None:
    _, scene = arms.bench(0, "servo_gain")
    kinds = drawn_kinds(np.random.default_rng(1), scene, "servo_gain", Site(1), 3)
    assert [weight for _, weight in kinds] == pytest.approx([1 / 3] * 3)
