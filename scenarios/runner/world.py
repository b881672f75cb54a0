"""The world that a scenario declares."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np

from armtwin.models.arm import Arm
from armtwin.models.camera import Camera
from armtwin.models.camera_files import nominal_camera
from armtwin.models.catalogue.injection import shifted_samples
from armtwin.models.catalogue.motion_injection import with_causes
from armtwin.models.catalogue.registry import effect_named
from armtwin.models.kinematics import Deviation
from armtwin.models.motion_arm import planar_arm
from armtwin.models.motion_world import MotionWorld, ideal_motion_world
from armtwin.models.world import World, ideal_world
from armtwin.scenarios.scenario import ScenarioFile


def declared_arm(scenario: ScenarioFile) -> Arm:
    """Return the arm as drawn, standing as the bench has it."""
    return replace(scenario.drawn_arm, gravity_m_s2=np.array(scenario.bench.gravity_m_s2))


def true_camera(scenario: ScenarioFile) -> Camera:
    """Return the camera as it truly stands: Table 2's, moved in its own axes."""
    rotation = np.asarray(cv2.Rodrigues(np.array(scenario.camera.turn_rad))[0], dtype=float)
    return nominal_camera().moved(rotation, np.array(scenario.camera.shift_mm))


def true_deviation(scenario: ScenarioFile) -> Deviation:
    """Return what the built arm differs by from the drawing."""
    table, none = scenario.geometry, Deviation.none(scenario.drawn_arm)
    return Deviation(
        np.array(table.length_errors_mm) if table.length_errors_mm else none.lengths_mm,
        np.array(table.joint_errors_rad) if table.joint_errors_rad else none.joints_rad,
    )


def build_motion_world(scenario: ScenarioFile) -> MotionWorld:
    """Build the world of the scenario's arm in motion, with every fault that a film of it shows."""
    arm = planar_arm(declared_arm(scenario), true_deviation(scenario))
    causes = [(effect.name, effect.site, effect.parameters) for effect in scenario.moving_effects]
    return with_causes(ideal_motion_world(arm), causes)


def build_world(scenario: ScenarioFile, samples_before: int = 0) -> World:
    """Build the bench with every fault of the scenario.

    `samples_before` poses were run earlier: what happens at some sample has then happened, or comes sooner.
    """
    world = ideal_world(
        declared_arm(scenario),
        true_camera(scenario),
        scenario.bench.arm_plane_z_mm,
        np.array(scenario.bench.base_in_board_mm),
        true_deviation(scenario),
    )
    for effect in scenario.effects:
        known = effect_named(effect.name)
        parameters = shifted_samples(known.injected, effect.parameters, world.arm, samples_before)
        world = known.inject(world, parameters, effect.site)
    return world
