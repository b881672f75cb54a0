import numpy as np
import pytest

from armtwin.models.arm import nominal_arm
from armtwin.models.catalogue.site import NOWHERE, Site
from armtwin.models.plan import paper_plan
from armtwin.scenarios.power.place import PlacePower, power_at
from armtwin.scenarios.power.power import over_places, places_of
from armtwin.scenarios.power.setting import Setting


@pytest.fixture(scope="module")
def setting() -> Setting:
    return Setting(paper_plan(nominal_arm()), 0.1, ("a", "b", "c", "f"))


def test_a_noise_twice_as_large_hides_a_gain_twice_as_large(setting: Setting) -> None:
    noisy = Setting(setting.plan, 0.2, setting.markers)
    quiet, loud = (power_at(one, "servo_gain", Site(1), 0, 1) for one in (setting, noisy))
    assert quiet.size_90 is not None
    assert loud.size_90 is not None
    assert loud.size_90 / quiet.size_90 == pytest.approx(2.0, rel=0.15)
    assert quiet.size_50 is not None
    assert quiet.size_50 < quiet.size_90
    assert all(low <= found <= high for low, found, high in zip(quiet.low, quiet.found, quiet.high, strict=True))


def test_what_the_geometry_takes_up_is_told_to_be_no_cause(setting: Setting) -> None:
    assert "gauge" in power_at(setting, "plane_offset", NOWHERE, 0, 1).why_not


def test_swapped_markers_are_found_in_the_size_that_they_have(setting: Setting) -> None:
    one = power_at(setting, "marker_swap", Site(marker="a"), 0, 1)
    assert one.fixed
    assert one.share > 0.9


def test_every_joint_of_a_joint_s_fault_is_a_place(setting: Setting) -> None:
    assert places_of(setting, "backlash") == [Site(1), Site(2), Site(3)]


def test_places_are_averaged_by_their_curves() -> None:
    low = PlacePower("backlash", Site(1), "rad", sizes=(0.1, 1.0, 10.0), found=(0.0, 1.0, 1.0))
    high = PlacePower("backlash", Site(2), "rad", sizes=(1.0, 10.0, 100.0), found=(0.0, 1.0, 1.0))
    half = over_places([low, high], 0.5)
    assert half == pytest.approx(1.0, rel=0.15)
    assert over_places([low], 0.5) == pytest.approx(np.sqrt(0.1), rel=0.1)
