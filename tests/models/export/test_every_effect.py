"""Every effect of the catalogue goes into a file or onto the list of what the file lacks, and the file loads."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest

from armtwin.models.arm import nominal_arm
from armtwin.models.camera_files import nominal_camera
from armtwin.models.catalogue.registry import catalogue
from armtwin.models.catalogue.sealed import Situation
from armtwin.models.export.mjcf import export_mjcf
from armtwin.models.export.urdf import export_urdf
from armtwin.models.kinematics import Deviation
from armtwin.models.twin import Twin, TwinEffect

ARM = replace(nominal_arm(), gravity_m_s2=np.array([0.0, -9.81]))

SITUATION = Situation(ARM, 100, 150.0, ARM.marker_names, lambda: np.full(100, 5.0), 10.0)


@pytest.mark.parametrize("name", sorted(name for name, effect in catalogue().items() if effect.sealed is not None))
def test_an_effect_is_held_or_named_as_missing(tmp_path: Path, name: str) -> None:
    sealed = catalogue()[name].sealed
    assert sealed is not None
    hidden = sealed.draw(np.random.default_rng(1), SITUATION)
    effect = TwinEffect(name, hidden.site.joint, hidden.site.marker, hidden.parameters(hidden.start))
    twin = Twin(ARM, Deviation.none(ARM), np.zeros(3), nominal_camera(), (effect,))
    for held in (export_mjcf(twin, tmp_path / "arm.xml"), export_urdf(twin, tmp_path / "arm.urdf")):
        named = [effect.effect for effect in held.held] + [one.effect.effect for one in held.not_held]
        assert named == [name]
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "arm.xml"))
    data = mujoco.MjData(model)
    data.ctrl[:] = 0.2
    mujoco.mj_step(model, data, 1000)
    assert model.nu == 3
    assert np.isfinite(data.qpos).all()
    assert mujoco.MjModel.from_xml_path(str(tmp_path / "arm.urdf")).njnt == 3
