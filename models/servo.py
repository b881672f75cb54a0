"""The hobby servo: what its data sheet says, and what of it had to be assumed."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from armtwin.models.toml_reader import read_toml
from armtwin.models.validation import FROM_LIST, NotNegative, Positive, Strict, check

# A nominal servo's loop answers in ten of these steps.
TIMESTEP_S = 0.002

NOMINAL_SERVO = Path(__file__).parent / "nominal" / "servo.toml"

# A loop of 20 ms takes 400 x 0.02 = 8 N m s/rad; over a step of 1 ms that is 0.008 kg m2, well below 0.03.
_GENTLE_STIFFNESS_NM_RAD = 400.0
_GENTLE_INERTIA_KG_M2 = 0.03
# Half the nominal approach speed: the loop then slows down at 40 rad/s2, less than a bearing's friction does.
_GENTLE_SPEED_RAD_S = 1.0
# With this step a link in play of 4 mrad rests within 2e-5 rad (RMS) of where it should, and a move within the gap
# drags it by up to 4e-5 rad; with 2 ms, and half the stiffness, which is all that it bears, within 7e-5 rad.
_GENTLE_TIMESTEP_S = 0.001


@dataclass(frozen=True)
class Servo:
    """A position servo, SI units; angles at its output shaft.

    Attributes:
        name: maker and type.
        stall_torque_nm, no_load_speed_rad_s: ends of the motor's torque-speed line.
        dead_band_us: pulse change that the control board ignores.
        weight_kg: mass of the servo itself.
        pulse_range_us, travel_rad: pulse widths at both ends, and the angle between them.
        frame_period_s: period of the command pulses.
        stiffness_nm_rad: torque of the control loop for each radian of error.
        loop_time_s: time constant with which the control loop closes an error.
        friction_nm: dry friction of the gear train.
        rotor_inertia_kg_m2: inertia of the rotor seen through the gear.
        approach_speed_rad_s: speed at which a new command is approached.
        gear_compliance_rad_nm: give between the potentiometer and the link.
        timestep_s: step of the simulation that resolves its loop.

    """

    name: str
    stall_torque_nm: float
    no_load_speed_rad_s: float
    dead_band_us: float
    weight_kg: float
    pulse_range_us: tuple[float, float]
    travel_rad: float
    frame_period_s: float
    stiffness_nm_rad: float
    loop_time_s: float
    friction_nm: float
    rotor_inertia_kg_m2: float
    approach_speed_rad_s: float
    gear_compliance_rad_nm: float
    timestep_s: float = TIMESTEP_S

    @property
    def rad_per_us(self) -> float:
        """Angle for each microsecond of pulse."""
        low, high = self.pulse_range_us
        return self.travel_rad / (high - low)

    @property
    def dead_band_rad(self) -> float:
        """The data sheet's dead band as an angle."""
        return self.dead_band_us * self.rad_per_us


class _ServoFile(Strict):
    """Keys of a servo file."""

    schema_: Literal["armtwin.servo/1"] = Field(alias="schema")
    name: Annotated[str, Field(min_length=1, max_length=100)]
    stall_torque_nm: Positive
    no_load_speed_rad_s: Positive
    dead_band_us: NotNegative
    weight_kg: Positive
    pulse_range_us: Annotated[tuple[Positive, Positive], FROM_LIST]
    travel_rad: Positive
    frame_period_s: Positive
    stiffness_nm_rad: Positive
    loop_time_s: Positive
    friction_nm: NotNegative
    rotor_inertia_kg_m2: Positive
    approach_speed_rad_s: Positive
    gear_compliance_rad_nm: NotNegative


def read_servo(path: Path) -> Servo:
    """Read a servo file (TOML, `armtwin.servo/1`); raises `InputError`."""
    table = check(_ServoFile, read_toml(path), path.name)
    return Servo(**table.model_dump(exclude={"schema_"}))


def nominal_servo() -> Servo:
    """Return the servo of the nominal arm, a TowerPro MG996R."""
    return read_servo(NOMINAL_SERVO)


def gentle(servo: Servo) -> Servo:
    """Return the servo with a stiffer loop, a heavier rotor and a slow approach; it rests at the same angles.

    Play and friction remember every overshoot, so a link must not coast ahead of its horn; and MuJoCo resolves stops
    and dry friction by the inertias alone, so these must outweigh the loop's damping over a time step.
    """
    return replace(
        servo,
        stiffness_nm_rad=_GENTLE_STIFFNESS_NM_RAD,
        rotor_inertia_kg_m2=_GENTLE_INERTIA_KG_M2,
        approach_speed_rad_s=_GENTLE_SPEED_RAD_S,
        timestep_s=_GENTLE_TIMESTEP_S,
    )
