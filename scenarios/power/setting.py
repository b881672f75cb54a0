"""What someone plans: the poses, the arm, the camera, the noise of a marker and the markers that are looked for."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.diagnosis.fit import Data
from armtwin.calib.diagnosis.holdout import held_out_rows
from armtwin.calib.diagnosis.problem import problem_of
from armtwin.models.arm import Arm, nominal_arm
from armtwin.models.camera import Camera
from armtwin.models.plan import Plan
from armtwin.models.recordings.recording import Recording, make_samples
from armtwin.models.world import World
from armtwin.sim.sealed import Scene, bench_of

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Setting:
    """A plan and what it is run with; None for arm and camera is the drawing's arm before the nominal webcam."""

    plan: Plan
    noise_px: float
    markers: tuple[str, ...]
    arm: Arm | None = None
    camera: Camera | None = None
    held_out: tuple[str, ...] = ()

    @property
    def drawing(self) -> Arm:
        """The arm as it is drawn."""
        return nominal_arm() if self.arm is None else self.arm

    def bench(self, rng: np.random.Generator, effect: str) -> tuple[World, Scene]:
        """Draw an arm as it might have been built, with gravity in its plane where the effect needs it."""
        return bench_of(
            rng, (effect,), self.arm, None, self.noise_px, self.markers, (self.plan, self.held_out), self.camera
        )


def data_without_noise(scene: Scene, world: World) -> Data:
    """Return what a diagnosis would weigh of a world on a scene if the noise, which is declared, were zero.

    The pixels are those of the physical simulation; what is held out does not count.
    """
    recording = recording_without_noise(scene, world)
    held, _, _ = held_out_rows(recording)
    problem = problem_of(recording)
    counts = np.isfinite(problem.observed).all(axis=-1) & ~held[:, None]
    return Data(problem, counts, scene.noise_px)


def recording_without_noise(scene: Scene, world: World) -> Recording:
    """Return what would be recorded if the noise, which is declared, were zero; faults of detection are left out."""
    seen = scene.pixels(world)
    return Recording(
        arm=world.arm,
        sample=make_samples(len(scene.plan)),
        time_s=scene.clock if scene.timed else np.full(len(scene.plan), np.nan),
        trajectory=scene.plan.trajectory,
        q_cmd=scene.plan.q_cmd,
        markers_px={name: seen[name] for name in scene.markers},
        payload_kg=scene.plan.payload_kg if scene.plan.payload_kg.any() else None,
        camera=world.camera,
        arm_plane_z_mm=world.arm_plane_z_mm,
        pixel_noise_px=scene.noise_px,
        held_out=scene.held_out,
    )


def with_noise(data: Data, rng: np.random.Generator) -> Data:
    """Return the data with one draw of the noise."""
    problem = data.problem
    noisy = problem.observed + data.noise * rng.standard_normal(problem.observed.shape)
    return replace(data, problem=replace(problem, observed=noisy))
