"""The world that a scenario declares."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import cv2
import numpy as np

from models.arm import Arm, nominal_arm
from models.camera import Camera
from models.camera_files import nominal_camera
from models.effects.registry import effect_named
from models.errors import InputError
from models.kinematics import Deviation
from models.world import World, ideal_world
from scenarios.scenario import ScenarioFile


def declared_arm(scenario: ScenarioFile) -> Arm:
    """Return the arm as drawn (Table 1), standing as the bench has it."""
    return replace(nominal_arm(), gravity_m_s2=np.array(scenario.bench.gravity_m_s2))


def true_camera(scenario: ScenarioFile) -> Camera:
    """Return the camera as it truly stands: Table 2's, moved in its own axes."""
    rotation = np.asarray(cv2.Rodrigues(np.array(scenario.camera.turn_rad))[0], dtype=float)
    return nominal_camera().moved(rotation, np.array(scenario.camera.shift_mm))


def true_deviation(scenario: ScenarioFile) -> Deviation:
    """Return what the built arm differs by from the drawing."""
    table = scenario.geometry
    return Deviation(np.array(table.length_errors_mm), np.array(table.joint_errors_rad))


def build_world(scenario: ScenarioFile, samples_before: int = 0) -> World:
    """Build the bench with every fault of the scenario; raises `InputError` that names the effect it cannot make.

    `samples_before` poses were run earlier: what happens at some sample has then happened, or comes sooner.
    """
    world = ideal_world(
        declared_arm(scenario),
        true_camera(scenario),
        scenario.bench.arm_plane_z_mm,
        np.array(scenario.bench.base_in_board_mm),
        true_deviation(scenario),
    )
    for number, effect in enumerate(scenario.effects):
        try:
            world = effect_named(effect.name).inject(
                world, _later(effect.parameters, samples_before), joint=effect.joint, marker=effect.marker
            )
        except InputError as error:
            raise InputError(f"effects.{number} ('{effect.name}'): {error}") from None
        except KeyError as error:
            raise InputError(f"effects.{number} ('{effect.name}'): key {error} is missing") from None
    return world


def _later(parameters: Mapping[str, float], samples_before: int) -> dict[str, float]:
    shifted = dict(parameters)
    if "from_sample" in shifted:
        shifted["from_sample"] = max(0.0, shifted["from_sample"] - samples_before)
    return shifted
