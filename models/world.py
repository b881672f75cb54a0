"""A world: the declared bench, and everything that is physically true of it and not declared.

An effect's injector takes a world and returns one with a physical fault added to the stage where it arises:

    command --electronics--> servo --mechanics, events--> arm --camera motion--> pixels --detections--> recording

No stage holds a formula of the estimator: play is a hinge with a gap, sag a spring under gravity, a bump a moved
camera. The stages are applied by the simulated bench, in the order in which they were added.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import mujoco
import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from armtwin.models.arm import Arm
from armtwin.models.camera import Camera
from armtwin.models.catalogue.site import Site
from armtwin.models.errors import InputError
from armtwin.models.kinematics import Deviation
from armtwin.models.mjcf import build_arm, building
from armtwin.models.servo import Servo, nominal_servo

Array = NDArray[np.float64]

# Usual time from a command to its picture, after which the next command follows at once: a move, a rest, a picture.
POSE_PERIOD_S = 1.5


@dataclass(frozen=True, eq=False)
class Command:
    """One command on its way to the servos: `q` (n,) rad for pose `sample`, given at `time_s`."""

    sample: int
    time_s: float
    q: Array


@dataclass(frozen=True)
class Moment:
    """When a picture is taken: the pose's `sample`, its `time_s`, and the `progress` of the recording, 0 to 1."""

    sample: int
    time_s: float
    progress: float


# Maps what is sent to what the servos are driven to, (n,) rad. It may remember what it was sent before, so a world
# holds its factory, and every run starts with a fresh one.
Electronics = Callable[[Command], Array]
# Edits the arm's MuJoCo model before it is compiled.
Mechanism = Callable[[mujoco.MjSpec], None]
# The camera as it stands when a picture is taken.
CameraMotion = Callable[[Camera, Moment], Camera]
# What detection makes of the markers' true pixels, by marker (N, 2): may draw from its generator.
Detection = Callable[[dict[str, Array], Generator], dict[str, Array]]


@dataclass(frozen=True, eq=False)
class Event:
    """Something that happens to the arm just before it is sent to pose `sample`."""

    sample: int
    happen: Callable[[mujoco.MjModel, mujoco.MjData], None]


@dataclass(frozen=True, eq=False)
class World:
    """The declared bench and the true one.

    Attributes:
        arm, camera, arm_plane_z_mm: as a recording declares them.
        servo: the servo of every joint.
        deviation: true lengths and joint zeros less the declared ones.
        base_in_board_mm: (3,) where marker A truly is in the board frame; its z is the arm's true plane.
        true_camera: the camera as it truly is when the recording starts.
        electronics: factories of the stages between the command and the servos.
        mechanics: edits of the arm's MuJoCo model.
        events: what happens to the arm on the way.
        camera_motion: what moves the true camera.
        detections: what detection does to the pixels.
        pose_period_s: usual time from a command to its picture, after which the next command follows at once.
        waits_for_rest: whether the arm rests in every picture; otherwise it is where it got to by then.
        picture_lag: the picture filed with pose i shows the arm at pose i - picture_lag.
        bendable: numbers of the links that are cut so that they may bend.
        relieved: hinges at which the static load of the arm's own mass is carried by something else (a balance).

    """

    arm: Arm
    camera: Camera
    arm_plane_z_mm: float
    servo: Servo
    deviation: Deviation
    base_in_board_mm: Array
    true_camera: Camera
    electronics: tuple[Callable[[], Electronics], ...] = ()
    mechanics: tuple[Mechanism, ...] = ()
    events: tuple[Event, ...] = ()
    camera_motion: tuple[CameraMotion, ...] = ()
    detections: tuple[Detection, ...] = ()
    pose_period_s: float = POSE_PERIOD_S
    waits_for_rest: bool = True
    picture_lag: int = 0
    bendable: tuple[int, ...] = ()
    relieved: tuple[str, ...] = ()

    def with_electronics(self, factory: Callable[[], Electronics]) -> World:
        """Return the world with one more stage between the command and the servos."""
        return replace(self, electronics=(*self.electronics, factory))

    def with_mechanism(self, mechanism: Mechanism, relieved: tuple[str, ...] = ()) -> World:
        """Return the world with one more edit of the arm's model, and the hinges of it that carry no static load."""
        return replace(self, mechanics=(*self.mechanics, mechanism), relieved=(*self.relieved, *relieved))

    def with_event(self, event: Event) -> World:
        """Return the world with one more thing that happens to the arm."""
        return replace(self, events=(*self.events, event))

    def with_camera_motion(self, motion: CameraMotion) -> World:
        """Return the world with one more thing that moves the camera."""
        return replace(self, camera_motion=(*self.camera_motion, motion))

    def with_detection(self, detection: Detection) -> World:
        """Return the world with one more thing that detection does."""
        return replace(self, detections=(*self.detections, detection))

    def camera_at(self, moment: Moment) -> Camera:
        """Return the true camera as it stands when a picture is taken."""
        camera = self.true_camera
        for motion in self.camera_motion:
            camera = motion(camera, moment)
        return camera

    def spec(self) -> mujoco.MjSpec:
        """Return the model of the true arm, with everything that was done to it."""
        spec = build_arm(self.arm, self.servo, self.deviation, self.bendable)
        for mechanism in self.mechanics:
            mechanism(spec)
        return spec

    def compile(self) -> mujoco.MjModel:
        """Compile the true arm, with everything that was done to it; raises `InputError` where none can have all."""
        with building():
            return self.spec().compile()


def ideal_world(
    arm: Arm,
    camera: Camera,
    arm_plane_z_mm: float,
    base_in_board_mm: Array | None = None,
    deviation: Deviation | None = None,
    servo: Servo | None = None,
) -> World:
    """Return the world in which all that is declared is true, but for a geometric `deviation`.

    Marker A stands at `base_in_board_mm` (2,) or (3,), by default at the board's origin; z is `arm_plane_z_mm`.
    """
    xy = np.zeros(2) if base_in_board_mm is None else np.asarray(base_in_board_mm, dtype=float)[:2]
    return World(
        arm=arm,
        camera=camera,
        arm_plane_z_mm=arm_plane_z_mm,
        servo=nominal_servo() if servo is None else servo,
        deviation=Deviation.none(arm) if deviation is None else deviation,
        base_in_board_mm=np.array([*xy, arm_plane_z_mm]),
        true_camera=camera,
    )


def joint_index(world: World, site: Site) -> int:
    """Index from 0 of a site's joint (link, axis), which counts from 1; raises `InputError` where there is none."""
    if site.joint is None or not 1 <= site.joint <= world.arm.n_joints:
        raise InputError(f"joint {site.joint}: this effect needs a joint from 1 to {world.arm.n_joints}")
    return site.joint - 1


def checked_marker(world: World, marker: str | None) -> str:
    """Return `marker`; raises `InputError` where the arm has none of that name."""
    if marker is None or marker not in world.arm.known_markers:
        raise InputError(f"marker {marker!r}: this effect needs one of {', '.join(world.arm.known_markers)}")
    return marker


def samples_of(parameters: Mapping[str, Any]) -> tuple[int, ...]:
    """Return the parameter `samples` in order."""
    return tuple(sorted(int(sample) for sample in parameters["samples"]))
