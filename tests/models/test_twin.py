"""Twin files: a measured bench that reads back the same and is rebuilt with its effects."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest
import tomli_w

from armtwin.models.arm import Arm, nominal_arm
from armtwin.models.camera_files import nominal_camera
from armtwin.models.catalogue import registry
from armtwin.models.catalogue.registry import effect_named
from armtwin.models.errors import InputError
from armtwin.models.kinematics import Deviation, marker_positions
from armtwin.models.toml_reader import read_toml
from armtwin.models.twin import Twin, TwinEffect, read_twin, rebuild, write_twin
from armtwin.models.world import Command, World
from armtwin.sim.physics.simulation import simulate

DEVIATION = Deviation(np.array([1.5, -2.0, 0.4, 0.1]), np.array([0.02, -0.03, 0.01]))
BASE_MM = np.array([40.3, -33.2, -80.87])


def twin(*effects: TwinEffect) -> Twin:
    return Twin(nominal_arm(), DEVIATION, BASE_MM, nominal_camera(), effects)


def test_it_reads_back_the_same(tmp_path: Path) -> None:
    written = twin(
        TwinEffect("backlash", 2, None, {"width_rad": 0.0123456789012345}),
        TwinEffect("marker_swap", None, "a", {"other": "b", "samples": [3, 7, 19]}),
        TwinEffect("joint_slip", 1, None, {"jump_rad": -0.02, "from_sample": 40}),
    )
    write_twin(tmp_path / "twin.toml", written, "how sure it is\nin two lines")
    read = read_twin(tmp_path / "twin.toml")
    np.testing.assert_array_equal(read.arm.link_lengths_mm, written.arm.link_lengths_mm)
    np.testing.assert_array_equal(read.deviation.lengths_mm, written.deviation.lengths_mm)
    np.testing.assert_array_equal(read.deviation.joints_rad, written.deviation.joints_rad)
    np.testing.assert_array_equal(read.base_in_board_mm, BASE_MM)
    assert read.camera is not None
    np.testing.assert_array_equal(read.camera.K, nominal_camera().K)
    np.testing.assert_allclose(read.camera.R_board_camera, nominal_camera().R_board_camera, atol=1e-15)
    assert [(e.effect, e.joint, e.marker, dict(e.parameters)) for e in read.effects] == [
        (e.effect, e.joint, e.marker, dict(e.parameters)) for e in written.effects
    ]


def test_its_comment_stands_at_its_head(tmp_path: Path) -> None:
    write_twin(tmp_path / "twin.toml", twin(), "how sure it is\nin two lines")
    assert (tmp_path / "twin.toml").read_text().startswith("# how sure it is\n# in two lines\nschema = ")


def test_the_rebuilt_bench_has_the_measured_geometry() -> None:
    q = np.array([[0.1, -0.2, 0.3], [-0.2, 0.1, 0.0]])
    markers = simulate(rebuild(twin()), q)[:, [0, 1, 2, 4], :2]
    np.testing.assert_allclose(markers, marker_positions(nominal_arm(), q, DEVIATION), atol=0.01)


def test_the_rebuilt_bench_has_its_effects_physically() -> None:
    world = rebuild(twin(TwinEffect("backlash", 2, None, {"width_rad": 0.02})))
    model = world.compile()
    np.testing.assert_allclose(model.joint("gap2").range, [-0.01, 0.01])


def test_a_sender_s_rounding_comes_before_the_servo_s_gain_whatever_the_order_in_the_file() -> None:
    gain, steps = (
        TwinEffect("servo_gain", 1, None, {"gain": 1.5}),
        TwinEffect("quantization", None, None, {"step_rad": 0.1}),
    )
    for effects in ((gain, steps), (steps, gain)):
        q = np.array([0.26, 0.0, 0.0])
        for make in rebuild(twin(*effects)).electronics:
            q = make()(Command(0, 0.0, q))
        assert q[0] == pytest.approx(0.3 * 1.5)


def test_a_twin_of_angles_alone_has_no_camera_and_can_still_be_rebuilt(tmp_path: Path) -> None:
    arm = Arm("elbow", np.array([80.0]), np.zeros(2))
    bare = Twin(arm, Deviation(np.zeros(1), np.array([0.2])), np.zeros(3), None, ())
    write_twin(tmp_path / "twin.toml", bare)
    read = read_twin(tmp_path / "twin.toml")
    assert read.camera is None
    tip = simulate(rebuild(read), np.array([[0.3]]))[0, -1, :2]
    np.testing.assert_allclose(tip, [80 * np.cos(0.5), 80 * np.sin(0.5)], atol=0.01)


def test_effects_that_no_bench_can_have_are_refused_by_name() -> None:
    with pytest.raises(InputError, match="effect 'backlash': key 'width_rad' is missing"):
        rebuild(twin(TwinEffect("backlash", 2, None, {})))
    with pytest.raises(InputError, match=r"effect 'backlash': width_rad: found -0\.1, a number from 0 to 1 is wanted"):
        rebuild(twin(TwinEffect("backlash", 2, None, {"width_rad": -0.1})))
    with pytest.raises(InputError, match="effect 'backlash': joint: found 9, a number from 1 to 3 is wanted"):
        rebuild(twin(TwinEffect("backlash", 9, None, {"width_rad": 0.1})))


def test_an_effect_that_stands_twice_at_one_joint_is_refused_by_name() -> None:
    gap = TwinEffect("backlash", 2, None, {"width_rad": 0.02})
    with pytest.raises(InputError, match="stands twice at one place, give it once"):
        rebuild(twin(gap, gap))


def test_an_effect_of_which_no_arm_can_be_compiled_is_refused_by_name(monkeypatch: pytest.MonkeyPatch) -> None:
    def inject(world: World, parameters: object, site: object) -> World:
        return world.with_mechanism(turn_the_range_round)

    def turn_the_range_round(spec: mujoco.MjSpec) -> None:
        spec.joint("joint1").limited = True
        spec.joint("joint1").range = [1.0, -1.0]

    torn = replace(effect_named("backlash"), name="torn", where="arm", injector=inject, injected=())
    monkeypatch.setitem(registry._LOADED, "torn", torn)
    with pytest.raises(InputError, match="effect 'torn': no such arm can be built"):
        rebuild(twin(TwinEffect("torn", None, None, {})))


@pytest.mark.parametrize(
    ("path", "value", "complaint"),
    [
        (("schema",), "armtwin.twin/2", "twin.toml: schema: "),
        (("geometri",), {}, "twin.toml: unknown key 'geometri'; did you mean 'geometry'"),
        (("arm", "link_lengths_mm"), [120.0, 121.7], "link_lengths_mm of planar3 needs 4 entries"),
        (
            ("geometry", "joint_errors_rad"),
            [0.0],
            "geometry.joint_errors_rad needs 3 entries for arm 'planar3', found 1",
        ),
        (("geometry", "length_errors_mm"), [0.0] * 5, "geometry.length_errors_mm needs 4 entries"),
        (("geometry", "length_errors_mm"), ["1", 0.0, 0.0, 0.0], "length_errors_mm entry 1: a number is wanted"),
        (("geometry", "base_in_board_mm"), [float("nan"), 0.0, 0.0], "geometry.base_in_board_mm entry 1: "),
        (("effects",), [{"effect": "backlsh"}], "effect 1: effect: unknown effect 'backlsh'; did you mean 'backlash'"),
        (("effects",), [{"effect": "backlash", "joint": 0}], "effect 1: joint"),
        (("effects",), [{"effect": "backlash", "width": 1}], "effect 1: unknown key 'width'"),
        (
            ("effects",),
            [{"effect": "backlash", "joint": 1, "parameters": {"width_rad": float("inf")}}],
            "effect 1: parameters.width_rad: found inf, a number from 0 to 1 is wanted",
        ),
        (
            ("effects",),
            [{"effect": "backlash", "joint": 1, "parameters": {"widht_rad": 0.01}}],
            "effect 1: unknown key 'parameters.widht_rad'; did you mean 'width_rad'?",
        ),
        (
            ("effects",),
            [{"effect": "backlash", "parameters": {"width_rad": 0.01}}],
            "effect 1: key 'joint' is missing: backlash sits at a joint, a number from 1 to 3 is wanted",
        ),
    ],
)
def test_a_broken_file_is_refused_in_one_line(
    tmp_path: Path, path: tuple[str, ...], value: object, complaint: str
) -> None:
    file = tmp_path / "twin.toml"
    write_twin(file, twin())
    content = read_toml(file)
    table = content
    for key in path[:-1]:
        table = table[key]
    table[path[-1]] = value
    file.write_text(tomli_w.dumps(content))
    with pytest.raises(InputError) as refused:
        read_twin(file)
    assert complaint in str(refused.value)
    assert "\n" not in str(refused.value)


def test_a_file_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file"):
        read_twin(tmp_path / "twin.toml")


def test_gravity_and_masses_belong_to_the_arm_of_the_file(tmp_path: Path) -> None:
    upright = replace(twin(), arm=replace(nominal_arm(), gravity_m_s2=np.array([0.0, -9.81]), tip_mass_kg=0.25))
    write_twin(tmp_path / "twin.toml", upright)
    model = rebuild(read_twin(tmp_path / "twin.toml")).compile()
    np.testing.assert_allclose(model.opt.gravity, [0.0, -9.81, 0.0])
    assert float(model.body("end3").mass[0]) == pytest.approx(0.25, rel=1e-3)
