import numpy as np
import pytest

from armtwin.calib.diagnosis.candidates import candidate_sites, fit_candidates
from armtwin.models.arm import nominal_arm
from armtwin.models.catalogue.site import NOWHERE, Site
from armtwin.models.plan import paper_plan
from armtwin.scenarios.power.arms import Arms
from armtwin.scenarios.power.contest import base_fit
from armtwin.scenarios.power.place import PlacePower, power_at
from armtwin.scenarios.power.power import over_places, places_of
from armtwin.scenarios.power.setting import Setting, data_without_noise
from armtwin.sim.sealed import Wanted, hide
from armtwin.sim.sealed.of_size import draw_at


@pytest.fixture(scope="module")
def arms() -> Arms:
    return Arms(Setting(paper_plan(nominal_arm()), 0.1, ("a", "b", "c", "f")), 0)


def test_a_noise_twice_as_large_hides_a_gain_twice_as_large(arms: Arms) -> None:
    noisy = Arms(Setting(arms.setting.plan, 0.2, arms.setting.markers), 0)
    quiet, loud = (power_at(one, "servo_gain", Site(1), 1) for one in (arms, noisy))
    assert quiet.size_90 is not None
    assert loud.size_90 is not None
    assert loud.size_90 / quiet.size_90 == pytest.approx(2.0, rel=0.15)
    assert quiet.size_50 is not None
    assert quiet.size_50 < quiet.size_90
    assert all(low <= found <= high for low, found, high in zip(quiet.low, quiet.found, quiet.high, strict=True))


def test_what_the_geometry_takes_up_is_told_to_be_no_cause(arms: Arms) -> None:
    assert "gauge" in power_at(arms, "plane_offset", NOWHERE, 1).why_not


def test_swapped_markers_are_found_in_the_size_that_they_have(arms: Arms) -> None:
    one = power_at(arms, "marker_swap", Site(marker="a"), 1)
    assert one.fixed
    assert one.share > 0.9


def test_every_joint_of_a_joint_s_fault_is_a_place(arms: Arms) -> None:
    assert places_of(arms, "backlash") == [Site(1), Site(2), Site(3)]


def test_places_are_averaged_by_their_curves() -> None:
    low = PlacePower("backlash", Site(1), "rad", sizes=(0.1, 1.0, 10.0), found=(0.0, 1.0, 1.0))
    high = PlacePower("backlash", Site(2), "rad", sizes=(1.0, 10.0, 100.0), found=(0.0, 1.0, 1.0))
    half = over_places([low, high], 0.5)
    assert half == pytest.approx(1.0, rel=0.15)
    assert over_places([low], 0.5) == pytest.approx(np.sqrt(0.1), rel=0.1)


def test_what_comes_near_a_fault_is_found_by_products_as_by_fits(arms: Arms) -> None:
    bench, scene = arms.bench(1, "backlash")
    hidden = draw_at(np.random.default_rng(0), scene, Wanted("backlash", 1.0, Site(2)))
    data, base = base_fit(data_without_noise(scene, hide(bench, "backlash", hidden, 0.001)))
    ranked = fit_candidates(data, base, candidate_sites(data))
    explained = [float(base.misfit.sum() - one.fit.misfit.sum()) for one in ranked]
    near = {one.active.key for one, gain in zip(ranked, explained, strict=True) if gain > 0.6 * max(explained)}
    found = arms.signatures("backlash").near(base.residual, 0.15 * max(explained), 8, Site(2))
    assert near <= {(effect.name, site.joint, site.marker) for effect, site in found}
