"""The catalogue of effects, and how one is added to it from outside the package."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from armtwin.models.catalogue import registry
from armtwin.models.catalogue.predict import Active
from armtwin.models.catalogue.registry import Site, catalogue, effect_named, register, register_file
from armtwin.models.errors import InputError
from tests.support.contexts import context_of, off_or, pixels

# The names that every file of this project uses.
NAMES = {
    *("backlash", "hysteresis", "dead_band", "quantization", "gravity_sag", "link_bending", "payload", "servo_gain"),
    *("servo_nonlinearity", "thermal_drift", "joint_slip", "settling_lag", "missed_command", "command_shift"),
    *("plane_offset", "camera_tilt", "camera_moved", "camera_drift", "focal_length", "lens_distortion"),
    *("marker_offset", "marker_swap", "outliers", "axis_tilt"),
}
# Rounding has no step at which it vanishes: the finest allowed one is tested with it.
FITTED = sorted(name for name in NAMES - {"quantization"} if catalogue()[name].is_fitted)


@pytest.fixture(autouse=True)
def _forget_what_was_added() -> Iterator[None]:
    known = dict(catalogue())
    yield
    registry._LOADED.clear()
    registry._LOADED.update(known)


def everywhere(name: str) -> list[tuple[Site, tuple[registry.Parameter, ...]]]:
    effect, context = effect_named(name), context_of()
    sites = [site for site in effect.sites(context) if name == "plane_offset" or not effect.applies(context, site)]
    return [(site, effect.parameters(context, site)) for site in sites]


def test_the_catalogue_has_every_effect_by_its_name() -> None:
    assert set(catalogue()) == NAMES
    assert all(name == effect.name for name, effect in catalogue().items())


@pytest.mark.parametrize("shape", [0.1, 0.9])
@pytest.mark.parametrize("name", FITTED)
def test_an_effect_that_is_off_changes_nothing_whatever_its_shape(name: str, shape: float) -> None:
    context = context_of()
    for site, parameters in everywhere(name):
        off = np.array([off_or(parameter, shape) for parameter in parameters])
        off_pixels = pixels(context, Active(effect_named(name), site, off))
        np.testing.assert_allclose(off_pixels, pixels(context), atol=1e-6, err_msg=str(site))


@pytest.mark.parametrize("name", FITTED)
def test_where_a_fit_begins_is_possible_and_predicts_pixels(name: str) -> None:
    context = context_of()
    for site, parameters in everywhere(name):
        for start in effect_named(name).starts(context, site, None):
            low, high = np.array([p.bounds for p in parameters]).T
            assert ((start >= low) & (start <= high)).all()
            assert np.isfinite(pixels(context, Active(effect_named(name), site, start))).all()


@pytest.mark.parametrize("name", sorted(NAMES))
def test_a_prediction_leaves_the_commands_as_they_are(name: str) -> None:
    context = context_of()
    before = context.q_cmd.copy()
    for site, _ in everywhere(name):
        for start in list(effect_named(name).starts(context, site, None))[:2]:
            pixels(context, Active(effect_named(name), site, start))
    np.testing.assert_array_equal(context.q_cmd, before)


@pytest.mark.parametrize("name", sorted(NAMES))
def test_an_effect_says_what_it_is_taken_for_and_what_tells_it_apart(name: str) -> None:
    effect = effect_named(name)
    assert set(effect.confused_with) <= NAMES - {name}
    assert effect.confused_with
    assert effect.experiment
    assert effect.summary


def test_an_effect_sits_at_each_joint_each_marker_or_in_one_place() -> None:
    context = context_of()
    assert [site.joint for site in effect_named("backlash").sites(context)] == [1, 2, 3]
    assert [site.marker for site in effect_named("marker_offset").sites(context)] == ["a", "b", "c", "f"]
    assert effect_named("camera_tilt").sites(context) == [Site()]


def test_a_misspelt_effect_is_answered_with_the_nearest_name() -> None:
    with pytest.raises(InputError, match="unknown effect 'backlsh'; did you mean 'backlash'"):
        effect_named("backlsh")


def test_a_name_can_be_taken_once_only() -> None:
    with pytest.raises(InputError, match="'backlash' is registered already"):
        register(effect_named("backlash"))


def test_a_file_adds_its_effect(tmp_path: Path) -> None:
    path = tmp_path / "twice.py"
    path.write_text(
        "from dataclasses import replace\n"
        "from armtwin.models.effects.servo_gain import EFFECT as GAIN\n"
        "EFFECT = replace(GAIN, name='gain_again')\n"
    )
    assert register_file(path).name == "gain_again"
    assert effect_named("gain_again").summary == effect_named("servo_gain").summary


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("x = 1\n", "defines no EFFECT"),
        ("EFFECT = 3\n", "defines no EFFECT"),
        ("def broken(:\n", "does not run: SyntaxError"),
        ("import no_such_module\n", "does not run: ModuleNotFoundError"),
        ("1 / 0\n", "does not run: ZeroDivisionError"),
    ],
)
def test_a_file_without_a_working_effect_is_refused_in_one_line(tmp_path: Path, text: str, complaint: str) -> None:
    path = tmp_path / "wrong.py"
    path.write_text(text)
    with pytest.raises(InputError, match=complaint) as refused:
        register_file(path)
    assert str(refused.value).startswith(str(path))


def test_a_file_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"nothing\.py: no such file"):
        register_file(tmp_path / "nothing.py")
