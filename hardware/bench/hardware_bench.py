"""The real bench: servos behind the serial link, the arm watched by the webcam.

The emulated bench is this class too, with an emulated Arduino at the port and a rendered stream as its camera.

    connect   link, camera, noise of the picture while the arm is limp
    move      the first: where the arm stands is looked up, the servos are armed there, and it sets out slowly
              every other: limits and step are checked, the command is sent, the picture is waited for
              each ends with the question whether the board is still armed: a limp arm stands still as well
    close     servos detached first, then the camera; also after an error, Ctrl-C or a lost camera
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from armtwin.hardware.bench.bench_file import BenchSetup
from armtwin.hardware.bench.posture import FindMarkers, joint_angles, link_vectors_mm
from armtwin.hardware.camera.frame_quality import fault_of
from armtwin.hardware.camera.settling import MotionError, Settling
from armtwin.hardware.camera.stillness import Grey, to_grey
from armtwin.hardware.camera.webcam import Picture, Webcam
from armtwin.hardware.link.servo_link import BoardResetError, BoardState, Hello, LinkError, RefusedError, ServoLink
from armtwin.models.bench import BenchDescription, Frame
from armtwin.models.errors import InputError, JobError
from armtwin.models.plan import steps_between

Array = NDArray[np.float64]

# The arm is built with joint zeros a few degrees off, so that it may stand a little outside its limits.
_ZERO_TOLERANCE_RAD = math.radians(8.0)
# A move shorter than this is less than half a pixel at the tip of the nominal arm: it need not show.
_VISIBLE_STEP_RAD = 2e-3
# One of this turns even the shortest link's marker by some pixels. A servo may miss a command; not so many on end.
_PLAIN_STEP_RAD = 0.05
_MOST_UNSEEN_MOVES = 3


class DetachedError(JobError):
    """The board has let the arm go limp by itself."""


class HardwareBench:
    """Satisfies `armtwin.models.bench.Bench` with an Arduino and a webcam."""

    def __init__(
        self,
        setup: BenchSetup,
        find_markers: FindMarkers | None = None,
        hang_by: Callable[[float], None] | None = None,
    ) -> None:
        """Note the setup; nothing is opened before `connect`.

        `find_markers` tells from the picture where the arm stands when it is armed; without it, or when a marker is
        hidden, the arm is taken to stand in the bench file's `rest_rad`. `hang_by` hangs a mass of so many kg at the
        tip, or asks someone to, and returns when it hangs.
        """
        camera = setup.camera
        self.setup = setup
        self.link = ServoLink(setup.port)
        self.webcam = Webcam(
            setup.camera_settings, camera.image_width, camera.image_height, frozen_s=setup.quality.frozen_s
        )
        self._settling = Settling(self.webcam, setup.settle)
        self.detached = True  # whether the servos are known to be without pulses
        self._find_markers = find_markers
        self._hang_by = hang_by
        self._q: Array | None = None
        self._resting: tuple[Picture, Grey] | None = None  # what the last move ended with, until it is captured
        self._unseen_moves = 0  # plain ones on end that the picture did not show
        self._started_s = 0.0
        self._origin_s: float | None = None
        self._sent_s: float | None = None

    @property
    def description(self) -> BenchDescription:
        """What the bench file says of it."""
        return replace(self.setup.description, hangs_loads=self._hang_by is not None)

    @property
    def notes(self) -> tuple[str, ...]:
        """What the webcam gave other than it was asked for."""
        return tuple(self.webcam.notes)

    @property
    def clock_origin_s(self) -> float | None:
        """Unix time at which it was connected."""
        return self._origin_s

    def hang(self, payload_kg: float) -> None:
        """Hang a mass at the tip, or wait until someone has; raises `InputError` where nobody can."""
        if self._hang_by is None:
            raise InputError(f"payload_kg: {payload_kg:g} is to hang at the tip, and nobody is there to hang it")
        self._hang_by(payload_kg)

    def connect(self) -> None:
        """Open both, and learn the picture's noise while the arm is limp.

        Raises `InputError` for a port, firmware or camera that cannot be used, `JobError` for a picture that cannot.
        """
        try:
            self._refuse_more_joints(self.link.connect())
            self.webcam.open()
            self._refuse_bad_picture(to_grey(self.webcam.newest().image))
            self._settling.learn_noise()
        except BaseException:
            self.close()
            raise
        self._started_s, self._origin_s, self._sent_s = time.monotonic(), time.time(), None

    def move(self, q_cmd_rad: Array) -> None:
        """Move to (n,) joint angles, rad, and return when the arm is still in the picture.

        The first move begins slowly from where the arm stands. Raises `InputError` for a pose outside the limits or too
        long a step, before anything is sent; `JobError` if the link or the camera is lost, the arm does not settle or
        the board has detached the servos.
        """
        q = np.asarray(q_cmd_rad, dtype=np.float64)
        self.setup.limits.check_pose(q, "command")
        if self._q is None:
            self._set_out(q)
            return
        self.setup.limits.check_step(self._q, q, "command")
        self._step(q, self.setup.motion.speed_rad_s)

    def capture(self) -> Frame:
        """Take one new picture of the arm; raises `JobError` if it is black, over-exposed, blurred or frozen."""
        picture, grey = self._resting or self._new_picture()
        self._resting = None
        self._refuse_bad_picture(grey)
        given_s = None if self._sent_s is None else self._sent_s - self._started_s
        return Frame(picture.image, picture.arrived_s - self._started_s, given_s)

    def film(self, time_s: Array, q_cmd: Array) -> Iterator[Frame]:
        """Stream (N, n) commands, rad, at (N,) times, s, from when the arm stands at the first; a picture after each.

        The board goes as fast as its slew limit lets it. Raises `InputError` for a pose outside the limits or too long
        a step, before anything is sent, and `JobError` as `move` does.
        """
        self.begin_film(q_cmd)
        return self._filmed(time_s - time_s[0], q_cmd)

    def begin_film(self, q_cmd: Array) -> None:
        """Check (N, n) commands, rad, and go to the first of them in steps as they are allowed; raises as `film`."""
        for before, q in zip([q_cmd[0], *q_cmd], q_cmd, strict=False):
            self.setup.limits.check_pose(q, "command")
            self.setup.limits.check_step(before, q, "command")
        self._resting, q = None, q_cmd[0]
        if self._q is None:
            self.move(q)
        for pose in steps_between(self._q, q, self.setup.limits.max_step_rad) if self._q is not None else ():
            self.move(pose)

    def send(self, q: Array) -> None:
        """Give one of a film's commands, (n,) rad; raises `JobError` as `move` does."""
        try:
            self.link.move(self.setup.servo_map.pulses_us(q), 0.0)
        except RefusedError:
            self._refuse_limp(self.link.state())
            raise
        self._q = q

    def _filmed(self, after_s: Array, q_cmd: Array) -> Iterator[Frame]:
        begun = time.monotonic()
        for wait_s, q in zip(after_s.tolist(), q_cmd, strict=True):
            time.sleep(max(0.0, begun + wait_s - time.monotonic()))
            shown = self.webcam.newest().number
            sent_s = self._sent_s = time.monotonic()
            self.send(q)
            picture = self.webcam.after(shown)
            yield Frame(picture.image, picture.arrived_s - self._started_s, sent_s - self._started_s)
        self._refuse_limp(self.link.state())

    def close(self) -> None:
        """Detach the servos, which `detached` tells of then, and release the camera. May be called twice."""
        try:
            self.detached = self.detached or self._detach()
            self.link.close()
        finally:
            self._q = None
            self.webcam.close()

    @property
    def hello(self) -> Hello:
        """What the board said of itself."""
        return self.link.hello()

    def arm_at(self, q: Array) -> None:
        """Arm the servos at (n,) joint angles and wait until the arm is still there; raises as `move` does.

        It jumps if it stands elsewhere, which nobody can know, so the time for a motion to show is always waited for.
        """
        self.setup.limits.check_pose(q, "arming")
        before = self._settling.now()
        sent_s = self._sent_s = time.monotonic()
        self.detached = False
        self.link.arm(self.setup.servo_map.pulses_us(q))
        self._q = q
        self._rest(before, sent_s)

    def posture(self) -> Array | None:
        """(n,) joint angles, rad, that the newest picture shows, or None when a marker is hidden.

        Raises `JobError` where no marker at all is seen.
        """
        if self._find_markers is None:
            return None
        setup = self.setup
        thought = setup.rest_rad if self._q is None else self._q
        markers = self._find_markers(self.webcam.newest().image, thought)
        if not markers:
            raise JobError(
                f"camera {self.webcam.source}: no marker is in the picture ({', '.join(setup.arm.marker_names)} are "
                "looked for); turn the camera to the arm, light the stickers"
            )
        links = link_vectors_mm(setup.arm, setup.camera, setup.arm_plane_z_mm, markers)
        return None if links is None else joint_angles(setup.arm, links)

    def __enter__(self) -> Self:
        self.connect()
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def _refuse_more_joints(self, hello: Hello) -> None:
        n_joints = self.setup.arm.n_joints
        if n_joints > hello.n_servos:
            raise InputError(
                f"serial port {self.setup.port}: its board drives {hello.n_servos} servos, the bench file has "
                f"{n_joints} joints"
            )

    def _detach(self) -> bool:
        """Detach the servos, and tell whether the board has said that they are."""
        try:
            self.link.detach()
        except BoardResetError:  # it boots detached
            return True
        except LinkError:
            return False
        return True

    def _set_out(self, q: Array) -> None:
        seen = self.posture()
        start = self.setup.rest_rad if seen is None else self._within_limits(seen)
        self.arm_at(start)
        for pose in steps_between(start, q, self.setup.limits.max_step_rad):
            self._step(pose, self.setup.motion.start_speed_rad_s)

    def _within_limits(self, seen: Array) -> Array:
        limits = self.setup.limits
        inside = np.clip(seen, limits.min_rad, limits.max_rad)
        off = np.abs(seen - inside)
        if off.max() > _ZERO_TOLERANCE_RAD:
            j = int(np.argmax(off))
            raise InputError(
                f"the arm: joint {j + 1} stands at {np.degrees(seen[j]):.0f} deg in the picture, outside its limits "
                f"{np.degrees(limits.min_rad[j]):.0f} to {np.degrees(limits.max_rad[j]):.0f} deg; "
                "turn the limp arm inside by hand"
            )
        return inside

    def _step(self, q: Array, speed_rad_s: float) -> None:
        """Send one command and wait for the picture to rest."""
        self._resting = None
        # Taken anew for each step: between two poses a mass may have been hung, or a lamp switched on.
        before = self._settling.now()
        distance = 0.0 if self._q is None else float(np.abs(q - self._q).max())
        sent_s = self._sent_s = time.monotonic()
        try:
            self.link.move(self.setup.servo_map.pulses_us(q), distance / speed_rad_s)
        except RefusedError:
            self._refuse_limp(self.link.state())
            raise
        self._q = q
        self._refuse_limp(self.link.wait())
        seen = self._rest(before if distance >= _VISIBLE_STEP_RAD else None, sent_s)
        self._refuse_unseen(seen or distance < _PLAIN_STEP_RAD)

    def _refuse_unseen(self, seen: bool) -> None:
        self._unseen_moves = 0 if seen else self._unseen_moves + 1
        if self._unseen_moves == _MOST_UNSEEN_MOVES:
            raise MotionError(
                f"camera {self.webcam.source}: the picture showed nothing of the last {_MOST_UNSEEN_MOVES} moves; is "
                "the servos' supply on, does the camera look at this arm, is its picture live?"
            )

    def _rest(self, before: Grey | None, sent_s: float) -> bool:
        """Wait for rest after a command; returns whether a motion showed."""
        rest = self._settling.wait(before, sent_s)
        # Asked after the picture was taken: what was armed then was armed all the while.
        self._refuse_limp(self.link.state())
        self._resting = rest.picture, rest.grey
        return rest.moved

    def _new_picture(self) -> tuple[Picture, Grey]:
        """Return the next picture of the arm as it stands."""
        picture = self.webcam.after(self.webcam.newest().number)
        if self._q is not None:
            self._refuse_limp(self.link.state())
        return picture, to_grey(picture.image)

    def _refuse_limp(self, state: BoardState) -> None:
        if not state.armed:
            raise DetachedError(
                f"serial port {self.setup.port}: the board has detached the servos by itself "
                f"({state.detach_reason.name.lower()}), as it does when it hears nothing for "
                f"{self.hello.silence_timeout_s:g} s: keep the machine awake and the program running"
            )

    def _refuse_bad_picture(self, grey: Grey) -> None:
        fault = fault_of(grey, self.setup.quality)
        if fault is not None:
            raise JobError(f"camera {self.webcam.source}: {fault}")
