"""What a bench file may hold (TOML, `armtwin.bench/1`); `bench_file.read_bench` turns it into a `BenchSetup`.

Defaults that are not obvious carry their reason. Lengths mm, angles rad, pulse widths us, times s.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BeforeValidator, Field, model_validator

from armtwin.hardware.link.messages import MAX_DURATION_S, MOST_SERVOS
from armtwin.models.plan import MAX_STEP_RAD
from armtwin.models.validation import Finite, NotNegative, Positive, Strict

# What the firmware allows (`hardware/firmware/armtwin_firmware/servos.h`): pulses that no common servo is harmed by.
FIRMWARE_MIN_US = 500.0
FIRMWARE_MAX_US = 2500.0

Pulse = Annotated[float, Field(ge=FIRMWARE_MIN_US, le=FIRMWARE_MAX_US, allow_inf_nan=False)]


def _not_true(value: object) -> object:
    """Refuse `true`, which a literal takes for the 1 that it equals."""
    if isinstance(value, bool):
        raise ValueError(f"1 or -1 is wanted, found {value}")
    return value


class JointTable(Strict):
    """One joint: the servo that turns it and how far it may turn."""

    servo: Annotated[int, Field(ge=1, le=MOST_SERVOS)]
    zero_us: Pulse = 1500.0
    # TowerPro's MG996R turns half a turn over 500 to 2500 us.
    us_per_rad: Annotated[float, Field(gt=50.0, lt=5000.0, allow_inf_nan=False)] = 636.62
    direction: Annotated[Literal[1, -1], BeforeValidator(_not_true)] = 1
    min_us: Pulse = FIRMWARE_MIN_US
    max_us: Pulse = FIRMWARE_MAX_US
    min_rad: Finite
    max_rad: Finite

    @model_validator(mode="after")
    def _limits_fit_the_servo(self) -> JointTable:
        if self.min_us >= self.max_us:
            raise ValueError(f"min_us {self.min_us:g} is not below max_us {self.max_us:g}")
        if self.min_rad >= self.max_rad:
            raise ValueError(f"min_rad {self.min_rad:g} is not below max_rad {self.max_rad:g}")
        ends = sorted((edge - self.zero_us) / (self.direction * self.us_per_rad) for edge in (self.min_us, self.max_us))
        for name, limit in (("min_rad", self.min_rad), ("max_rad", self.max_rad)):
            if not ends[0] - 1e-9 <= limit <= ends[1] + 1e-9:
                raise ValueError(
                    f"{name} {limit:g} lies outside the servo's range, {ends[0]:.4f} to {ends[1]:.4f} rad "
                    f"({self.min_us:g} to {self.max_us:g} us); narrow the limit, or check zero_us and us_per_rad"
                )
        return self


class SerialTable(Strict):
    """The Arduino's port."""

    port: Annotated[str, Field(min_length=1, max_length=1000)]


class CameraSettings(Strict):
    """The webcam and what is asked of it; a setting that is left out is left to the camera."""

    source: Annotated[str, Field(min_length=1, max_length=2000)]
    calibration: Annotated[str, Field(min_length=1, max_length=1000)]
    arm_plane_z_mm: Finite
    fps: Positive | None = None
    focus: NotNegative | None = None
    exposure: Finite | None = None
    white_balance_k: Positive | None = None


class MotionTable(Strict):
    """How the arm is moved."""

    max_step_rad: Positive = MAX_STEP_RAD
    speed_rad_s: Annotated[float, Field(gt=0, le=3.0, allow_inf_nan=False)] = 1.0
    # A fifth of the usual speed: time to reach for the plug if the arm sets out the wrong way.
    start_speed_rad_s: Annotated[float, Field(gt=0, le=1.0, allow_inf_nan=False)] = 0.2
    rest_rad: list[Finite] | None = None


class SettleTable(Strict):
    """When the arm counts as still in the picture."""

    # Three to four frames of a 25 or 30 Hz webcam: one pair of equal frames may be the end of a swing.
    still_s: Annotated[float, Field(gt=0, le=10, allow_inf_nan=False)] = 0.12
    # A move must show in the picture within this time; beyond it the arm is taken not to have moved. It bounds the
    # delay of the stream that can be told from an arm that stands.
    onset_s: Annotated[float, Field(gt=0, le=30, allow_inf_nan=False)] = 1.5
    timeout_s: Annotated[float, Field(gt=0, le=120, allow_inf_nan=False)] = 10.0

    @model_validator(mode="after")
    def _rests_later_than_it_sets_out(self) -> SettleTable:
        for key in ("onset_s", "still_s"):
            least_s: float = getattr(self, key)
            if self.timeout_s <= least_s:
                raise ValueError(
                    f"timeout_s is {self.timeout_s:g}, more than {key} {least_s:g} is wanted: "
                    "an arm takes longer to come to rest than that"
                )
        return self


class QualityTable(Strict):
    """Pictures outside these bounds are refused."""

    min_brightness: Annotated[float, Field(ge=0, le=255)] = 12.0
    max_saturated_share: Annotated[float, Field(gt=0, le=1)] = 0.35
    # A sharp webcam's edges measure 3 px (photographs of a chessboard, 640x480), blurred by sigma = 2 px 6, by 3 px 8.
    max_edge_px: Annotated[float, Field(gt=0, le=100)] = 7.0
    # Twice as long as a stream that falls a second behind is silent.
    frozen_s: Annotated[float, Field(gt=0, le=60)] = 2.0


class BenchTable(Strict):
    """The whole bench file."""

    schema_: Literal["armtwin.bench/1"] = Field(alias="schema")
    kind: Literal["hardware"] = "hardware"
    arm: Annotated[str, Field(min_length=1, max_length=1000)] | None = None
    serial: SerialTable
    camera: CameraSettings
    joints: Annotated[list[JointTable], Field(min_length=1, max_length=MOST_SERVOS)]
    motion: MotionTable = MotionTable()
    settle: SettleTable = SettleTable()
    quality: QualityTable = QualityTable()

    @model_validator(mode="after")
    def _is_consistent(self) -> BenchTable:
        servos = sorted(joint.servo for joint in self.joints)
        if servos != list(range(1, len(servos) + 1)):
            raise ValueError(f"joints: each servo 1 to {len(servos)} turns one joint, found servos {servos}")
        self._refuse_slow_motion()
        rest = self.motion.rest_rad
        if rest is not None and len(rest) != len(self.joints):
            raise ValueError(f"motion.rest_rad needs {len(self.joints)} angles, one a joint, found {len(rest)}")
        for number, (joint, angle) in enumerate(zip(self.joints, rest or [0.0] * len(servos), strict=True), start=1):
            if not joint.min_rad <= angle <= joint.max_rad:
                raise ValueError(
                    f"motion.rest_rad of joint {number} is {angle:g}, outside its limits "
                    f"{joint.min_rad:g} to {joint.max_rad:g}; the arm starts from there"
                )
        return self

    def _refuse_slow_motion(self) -> None:
        """Refuse a speed that would make a permitted step longer than the board's longest move."""
        step = min(self.motion.max_step_rad, max(joint.max_rad - joint.min_rad for joint in self.joints))
        slowest = step / MAX_DURATION_S
        for key in ("start_speed_rad_s", "speed_rad_s"):
            speed: float = getattr(self.motion, key)
            if speed < slowest:
                raise ValueError(
                    f"motion.{key} is {speed:g}, at least {slowest:.2g} is wanted: a step of {step:g} rad would take "
                    f"{step / speed:.0f} s, {MAX_DURATION_S:.0f} s is the longest move; or lower motion.max_step_rad"
                )
