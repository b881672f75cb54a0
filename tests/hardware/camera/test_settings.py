"""Driven through a scripted device: a V4L2 camera cannot be had without its kernel driver."""

import cv2
import pytest

from armtwin.hardware.bench.tables import CameraSettings
from armtwin.hardware.camera.settings import apply_settings, refuse_mismatch
from armtwin.models.errors import InputError

WANTED = CameraSettings(
    source="/dev/video0",
    calibration="camera.yaml",
    arm_plane_z_mm=-80.87,
    fps=30,
    focus=40,
    exposure=150,
    white_balance_k=4600,
)


class ScriptedCamera:
    """Takes what it is told, but for the properties that it lacks; notes the order."""

    def __init__(self, fixed: dict[int, float] | None = None) -> None:
        self.fixed = fixed or {}
        self.values: dict[int, float] = {}
        self.order: list[tuple[int, float]] = []

    def set(self, prop: int, value: float) -> bool:
        self.order.append((prop, value))
        self.values[prop] = self.fixed.get(prop, value)
        return prop not in self.fixed

    def get(self, prop: int) -> float:
        return self.values.get(prop, 0.0)


def test_every_setting_is_read_back():
    answers = apply_settings(ScriptedCamera(), WANTED, 1280, 720)

    assert [answer.key for answer in answers] == [
        "image_width",
        "image_height",
        "fps",
        "exposure",
        "focus",
        "white_balance_k",
    ]
    assert refuse_mismatch("/dev/video0", answers) == []


def test_size_is_set_before_rate_and_format_before_both():
    camera = ScriptedCamera()

    apply_settings(camera, WANTED, 1280, 720)

    order = [prop for prop, _ in camera.order]
    wanted = [cv2.CAP_PROP_FOURCC, cv2.CAP_PROP_FRAME_WIDTH, cv2.CAP_PROP_FRAME_HEIGHT, cv2.CAP_PROP_FPS]
    assert [prop for prop in order if prop in wanted] == wanted


def test_exposure_is_set_auto_then_manual_then_value():
    camera = ScriptedCamera()

    apply_settings(camera, WANTED, 1280, 720)

    steps = [pair for pair in camera.order if pair[0] in (cv2.CAP_PROP_AUTO_EXPOSURE, cv2.CAP_PROP_EXPOSURE)]
    assert steps == [
        (cv2.CAP_PROP_AUTO_EXPOSURE, 3.0),
        (cv2.CAP_PROP_AUTO_EXPOSURE, 1.0),
        (cv2.CAP_PROP_EXPOSURE, 150.0),
    ]


def test_settings_left_out_are_left_to_the_camera():
    camera = ScriptedCamera()
    plain = CameraSettings(source="/dev/video0", calibration="camera.yaml", arm_plane_z_mm=0.0)

    answers = apply_settings(camera, plain, 640, 480)

    assert [answer.key for answer in answers] == ["image_width", "image_height"]
    assert cv2.CAP_PROP_FOCUS not in camera.values


def test_a_size_that_the_camera_refuses_ends_the_job():
    camera = ScriptedCamera({cv2.CAP_PROP_FRAME_WIDTH: 640.0, cv2.CAP_PROP_FRAME_HEIGHT: 480.0})

    with pytest.raises(InputError, match=r"image_width 1280 \(it answered 640\), image_height 720 \(it answered 480\)"):
        refuse_mismatch("/dev/video0", apply_settings(camera, WANTED, 1280, 720))


def test_all_refused_controls_are_named_at_once():
    camera = ScriptedCamera({cv2.CAP_PROP_FOCUS: -1.0, cv2.CAP_PROP_WB_TEMPERATURE: 0.0})

    with pytest.raises(InputError, match=r"focus 40 \(it answered -1\), white_balance_k 4600 .* leave the key out"):
        refuse_mismatch("/dev/video0", apply_settings(camera, WANTED, 1280, 720))


def test_a_rate_that_the_camera_refuses_is_only_noted():
    camera = ScriptedCamera({cv2.CAP_PROP_FPS: 10.0})

    notes = refuse_mismatch("/dev/video0", apply_settings(camera, WANTED, 1280, 720))

    assert notes == ["camera /dev/video0: refused fps 30 (it answered 10); it runs at its own rate"]
