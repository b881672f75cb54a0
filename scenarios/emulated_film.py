"""The other half of the emulated bench: pulses from the emulated Arduino move the simulated arm, which is filmed.

    AVR pins --pulse widths--> servo map --angles--> MuJoCo --poses--> lens, sensor --JPEG--> MJPEG over HTTP

Runs in a process of its own (`film`), as the camera and the arm of a real bench go on whatever the host does. It obeys
words from a pipe, and ends when the pipe closes.
"""

from __future__ import annotations

import multiprocessing
import os
import time
from collections import deque
from collections.abc import Callable
from dataclasses import replace
from multiprocessing.connection import Connection

import cv2
import numpy as np
from numpy.typing import NDArray

from armtwin.hardware.bench.servo_map import ServoMap
from armtwin.hardware.emulator import FirmwareEmulator, Pulse
from armtwin.hardware.emulator.mjpeg import MjpegServer, to_jpeg
from armtwin.models.camera import project
from armtwin.models.coordinate_frames import robot_to_board
from armtwin.models.errors import ArmtwinError
from armtwin.models.world import World
from armtwin.sim.arm_view import arm_scene, bodies_in_robot, bodies_on_board
from armtwin.sim.physics.simulation import ArmSimulation
from armtwin.sim.render import LensRenderer
from armtwin.sim.sensor import Sensor, expose

Array = NDArray[np.float64]
Linear = NDArray[np.float32]

FRAME_PERIOD_S = 1.0 / 30.0  # a usual webcam's
PULSE_PERIOD_S = 0.02
# Poses closer than this look alike: a hundredth of a pixel at the tip.
_SAME_RAD = 1e-5
# A hand before a marker, px: wider than the sticker.
_HAND_RADIUS_PX = 60


class Faults:
    """What happens to the stream: words from the pipe change it."""

    def __init__(self) -> None:
        self.frozen = False
        self.stalled = False
        self.delay_s = 0.0
        self.hidden: set[str] = set()
        self.payload_kg = 0.0
        self.held = False  # emulated time is led from outside, and no stream is shown


class Film:
    """The arm of a world, turned by pulses and seen by the world's true camera."""

    def __init__(self, world: World, servo_map: ServoMap, sensor: Sensor, shadows: bool) -> None:
        self._world = world
        self._servo_map = servo_map
        self._arm = ArmSimulation(world)
        self._renderer = LensRenderer(world.true_camera, arm_scene(self._arm), shadows=shadows)
        self._blur = sensor.blur_sigma_px
        self._sensor = replace(sensor, blur_sigma_px=0.0)
        self._rng = np.random.default_rng(0)
        self._angles = np.zeros(world.arm.n_joints)
        self._pulses_us = servo_map.pulses_us(self._angles)
        self._emulated_s = 0.0
        self._seen: Array | None = None
        self._light: Linear = np.empty((0, 0, 3), np.float32)

    def follow(self, pulse: Pulse) -> None:
        """Let the arm move until the end of a pulse, and take it; a servo without pulses stays where it is."""
        self.advance(pulse.time_s)
        self._pulses_us[pulse.servo] = pulse.width_us
        self._angles = self._servo_map.angles_rad(self._pulses_us)

    def advance(self, now_s: float) -> None:
        """Let the arm move on until `now_s` of emulated time."""
        while self._emulated_s + PULSE_PERIOD_S <= now_s:
            self._drive(PULSE_PERIOD_S)

    def advance_to(self, now_s: float) -> None:
        """Let the arm move on until `now_s` of emulated time, to a step of its physics."""
        self.advance(now_s)
        step_s = float(self._arm.model.opt.timestep)
        if now_s - self._emulated_s > 0.5 * step_s:
            self._drive(round((now_s - self._emulated_s) / step_s) * step_s)

    def _drive(self, seconds: float) -> None:
        self._arm.drive(self._angles, seconds)
        self._emulated_s += seconds

    def picture(self, hidden: set[str]) -> NDArray[np.uint8]:
        """Film the arm as it stands: (H, W, 3) BGR, new noise each time."""
        qpos = np.array(self._arm.data.qpos)
        if self._seen is None or np.abs(qpos - self._seen).max() > _SAME_RAD:
            light = self._renderer.render_linear(bodies_on_board(self._world, bodies_in_robot(self._arm)))
            self._light = np.asarray(cv2.GaussianBlur(light, (0, 0), self._blur), np.float32) if self._blur else light
            self._seen = qpos
        light = self._light
        if hidden:
            light = light.copy()
            for u, v in self._marker_pixels(hidden):
                cv2.circle(light, (round(u), round(v)), _HAND_RADIUS_PX, (0.35, 0.40, 0.55), -1, cv2.LINE_AA)
        return expose(light, self._sensor, self._rng)

    def hang(self, payload_kg: float) -> None:
        """Hang a mass at the tip."""
        self._arm.hang(payload_kg)

    def quicken(self) -> None:
        """Let the servos approach what they hear as fast as their data sheet says, instead of settling gently."""
        self._arm.approach_at(self._world.servo.no_load_speed_rad_s)

    def close(self) -> None:
        """Free the renderer."""
        self._renderer.close()

    def _marker_pixels(self, names: set[str]) -> Array:
        points = self._arm.markers_mm()[[self._arm.marker_names.index(name) for name in sorted(names)]]
        return project(self._world.true_camera, robot_to_board(points, self._world.base_in_board_mm))


def film(
    pipe: Connection, make_world: Callable[[], World], servo_map: ServoMap, sensor: Sensor, shadows: bool, speed: float
) -> None:
    """Run the emulated bench until the pipe closes: the child's whole life.

    Sends ("ready", port, url) or ("failed", message) first; then answers each word with ("done",) or its result.
    """
    os.setsid()  # Ctrl-C at the terminal is for the host: a bench does not hear it
    try:
        with FirmwareEmulator(speed=speed) as board, MjpegServer() as server:
            scene = Film(make_world(), servo_map, sensor, shadows)
            server.publish(to_jpeg(scene.picture(set())))
            pipe.send(("ready", board.port, server.url))
            _run(pipe, board, server, scene, speed)
            scene.close()
    except ArmtwinError as error:
        pipe.send(("failed", str(error)))
    except (EOFError, BrokenPipeError):
        return


def _run(pipe: Connection, board: FirmwareEmulator, server: MjpegServer, scene: Film, speed: float) -> None:
    faults = Faults()
    queue: deque[tuple[float, bytes]] = deque()
    parent = multiprocessing.parent_process()
    due_s = filmed_s = 0.0
    shown = b""
    while parent is not None and parent.is_alive():  # whose pipe a grandchild may hold open when it was killed
        while pipe.poll(max(0.0, due_s - time.monotonic())):
            pipe.send(_obey(pipe.recv(), board, server, faults, scene))
        due_s = max(due_s + FRAME_PERIOD_S, time.monotonic())
        scene.hang(faults.payload_kg)
        if faults.held:
            continue
        for pulse in board.drain():
            scene.follow(pulse)
        now_s = board.time_s
        scene.advance(now_s)
        # The camera runs on emulated time: on a busy machine that stands still now and then, and a film of an arm that
        # stands because its world does would show rest where there is none.
        if faults.stalled or now_s - filmed_s < 0.9 * FRAME_PERIOD_S * speed:
            continue
        filmed_s = now_s
        if faults.frozen:
            server.publish(shown)
            continue
        queue.append((time.monotonic() + faults.delay_s, to_jpeg(scene.picture(faults.hidden))))
        while queue and queue[0][0] <= time.monotonic():
            shown = queue.popleft()[1]
            server.publish(shown)


def _held(board: FirmwareEmulator, scene: Film, until_s: float) -> float:
    """Let the emulated world run until a time, where it stands; return it."""
    board.run_until(until_s)
    for pulse in board.drain():
        scene.follow(pulse)
    scene.advance_to(board.time_s)
    return board.time_s


def _obey(
    words: tuple[object, ...], board: FirmwareEmulator, server: MjpegServer, faults: Faults, scene: Film
) -> tuple[object, ...]:
    match words:
        case ("widths",):
            return ("done", board.widths_us())
        case ("unplug" | "plug" | "reset" as word,):
            {"unplug": board.unplug, "plug": board.plug, "reset": board.reset}[str(word)]()
        case ("freeze", bool(on)):
            faults.frozen = on
        case ("stall", bool(on)):
            faults.stalled = on
        case ("late", float(seconds)):
            faults.delay_s = seconds
        case ("hide", str(name)):
            faults.hidden.add(name)
        case ("show", str(name)):
            faults.hidden.discard(name)
        case ("payload", float(mass)):
            faults.payload_kg = mass
        case ("hold",):
            faults.held = True
            return ("done", _held(board, scene, (int(board.time_s / PULSE_PERIOD_S) + 2) * PULSE_PERIOD_S))
        case ("step", float(until_s)):
            board.wait_for_bytes()
            seen_s = _held(board, scene, until_s)
            return ("done", seen_s, to_jpeg(scene.picture(faults.hidden)))
        case ("release",):
            faults.held = False
            board.run_free()
        case ("quicken",):
            scene.quicken()
        case ("drop",):
            server.drop_clients()
        case _:
            raise ValueError(f"unknown words {words}")
    return ("done",)
