"""Arms of one to six joints go into both formats."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest

from armtwin.models.arm import Arm
from armtwin.models.export.mjcf import export_mjcf
from armtwin.models.export.urdf import export_urdf
from armtwin.models.kinematics import Deviation, forward
from armtwin.models.twin import Twin


@pytest.mark.parametrize("n", [1, 2, 4, 6])
def test_the_tip_of_a_chain_stands_where_its_geometry_puts_it(tmp_path: Path, n: int) -> None:
    arm = Arm("chain", np.linspace(100.0, 60.0, n), np.zeros(2))
    deviation = Deviation(np.linspace(-2.0, 2.0, n), np.linspace(0.03, -0.02, n))
    twin = Twin(arm, deviation, np.zeros(3), None, ())
    q = np.linspace(0.3, -0.2, n)
    wanted = forward(arm, q[None], deviation)[0, :2]
    tip = f"marker_{arm.marker_names[-1]}"

    export_mjcf(twin, tmp_path / "arm.xml")
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "arm.xml"))
    data = mujoco.MjData(model)
    data.ctrl[:] = q
    mujoco.mj_step(model, data, 2000)
    np.testing.assert_allclose(1e3 * data.site(tip).xpos[:2], wanted, atol=0.02)

    export_urdf(twin, tmp_path / "arm.urdf")
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "arm.urdf"))
    data = mujoco.MjData(model)
    data.qpos[:] = q
    mujoco.mj_kinematics(model, data)
    np.testing.assert_allclose(1e3 * data.body(tip).xpos[:2], wanted, atol=1e-3)
