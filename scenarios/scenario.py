"""Scenario files (`armtwin.scenario/1`): what is true of a simulated bench, and what is done with it.

A scenario is TOML. Every table but `[trajectories]` may be left out; the defaults are the paper's experiment on an
ideal bench. Unknown keys are refused with the nearest valid name.
"""

from __future__ import annotations

import hashlib
import json
import tomllib
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, field_validator, model_validator

from armtwin.models.arm import Arm, arm_from_table, nominal_arm
from armtwin.models.arm_form import MOST_JOINTS
from armtwin.models.camera_files import nominal_camera
from armtwin.models.catalogue.injection import Stated
from armtwin.models.catalogue.motion_injection import inject_in_motion
from armtwin.models.catalogue.registry import effect_named
from armtwin.models.catalogue.site import Site
from armtwin.models.errors import InputError, UnreachablePoseError, nearest
from armtwin.models.inverse_kinematics import inverse
from armtwin.models.motion_arm import planar_arm
from armtwin.models.motion_world import ideal_motion_world
from armtwin.models.trajectories import CIRCLE_CENTRE_MM, ORIENTATION_RAD, SAMPLES, circle, line
from armtwin.models.twin import read_twin
from armtwin.models.validation import FROM_LIST, ArmTable, Finite, JointError, LengthError, Positive, Strict, check, row
from armtwin.models.world import ideal_world
from armtwin.scenarios.twins.as_scenario import scenario_table

Array = NDArray[np.float64]

FILES = Path(__file__).parent / "files"
_MAX_BYTES = 1 << 20

Point = Annotated[tuple[Finite, Finite], FROM_LIST]
Triple = Annotated[tuple[Finite, Finite, Finite], FROM_LIST]
# A gauge lies within the camera's picture of a table.
GaugeLength = Annotated[float, Field(gt=0, le=1000.0, allow_inf_nan=False)]
# A trajectory names folders and table columns.
Name = Annotated[str, Field(pattern=r"^[a-z][a-z0-9_]{0,40}$")]


class CircleTable(Strict):
    """A circle for the tip, from its rightmost point, anticlockwise."""

    kind: Literal["circle"]
    radius_mm: Positive
    centre_mm: Point = CIRCLE_CENTRE_MM
    orientation_rad: Finite = ORIENTATION_RAD
    samples: Annotated[int, Field(ge=2, le=10000)] = SAMPLES

    def poses(self) -> Array:
        """(samples, 3) x mm, y mm, theta rad."""
        return circle(self.centre_mm, self.radius_mm, self.samples, self.orientation_rad)


class LineTable(Strict):
    """A straight segment for the tip, both ends included."""

    kind: Literal["line"]
    start_mm: Point
    end_mm: Point
    orientation_rad: Finite = ORIENTATION_RAD
    samples: Annotated[int, Field(ge=2, le=10000)] = SAMPLES

    def poses(self) -> Array:
        """(samples, 3) x mm, y mm, theta rad."""
        return line(self.start_mm, self.end_mm, self.samples, self.orientation_rad)


Path2d = Annotated[CircleTable | LineTable, Field(discriminator="kind")]


class GeometryTable(Strict):
    """What the built arm differs by from the drawing (Table 4): one entry a length and a joint, or none at all."""

    length_errors_mm: Annotated[tuple[LengthError, ...], Field(max_length=MOST_JOINTS + 1), FROM_LIST] = ()
    joint_errors_rad: Annotated[tuple[JointError, ...], Field(max_length=MOST_JOINTS), FROM_LIST] = ()


class BenchTable(Strict):
    """Where the arm stands and which way gravity pulls."""

    base_in_board_mm: Point = (0.0, 0.0)
    # Section 3.2: the arm's plane in the board frame, as the bench was measured with a ruler.
    arm_plane_z_mm: Finite = -80.87
    gravity_m_s2: Point = (0.0, 0.0)


class CameraTable(Strict):
    """Where the camera truly stands against Table 2, in camera axes; the pipeline has to find out by calibration."""

    shift_mm: Triple = (0.0, 0.0, 0.0)
    turn_rad: Triple = (0.0, 0.0, 0.0)


class PictureTable(Strict):
    """What optics and sensor do to a frame: keys and defaults of `sim.sensor.Sensor`, and the lamp's shadows."""

    blur_sigma_px: Annotated[float, Field(ge=0, le=20)] = 0.7
    exposure: Annotated[float, Field(gt=0, le=4)] = 1.0
    vignetting: Annotated[float, Field(ge=0, lt=1)] = 0.15
    full_well_electrons: Annotated[float, Field(ge=0, le=1e6)] = 9000.0
    read_noise_electrons: Annotated[float, Field(ge=0, le=1e5)] = 15.0
    exposure_time_s: Annotated[float, Field(ge=0, le=0.1)] = 0.008
    shadows: bool = True


Share = Annotated[float, Field(ge=0, le=1)]


class ObstacleTable(Strict):
    """Something that stands between the camera and the arm, given in the robot frame: a hand, a lamp's arm, a cable."""

    centre_mm: Point
    size_mm: Annotated[tuple[Positive, Positive], FROM_LIST]
    before_arm_mm: Positive = 30.0
    thickness_mm: Positive = 5.0
    colour: Annotated[tuple[Share, Share, Share], FROM_LIST] = (0.25, 0.2, 0.15)


class EffectTable(Strict):
    """One physical fault of the bench: an effect of the catalogue, where it sits, and its parameters."""

    name: str
    joint: int | None = None
    marker: Annotated[str, Field(max_length=100)] | None = None
    parameters: dict[str, Any] = Field(default_factory=dict)  # checked by the effect

    @property
    def site(self) -> Site:
        """Where it sits."""
        return Site(self.joint, self.marker)


class ScenarioFile(Strict):
    """A whole scenario; every trajectory but `validate_on` is calibrated on."""

    schema_: Literal["armtwin.scenario/1"] = Field(alias="schema")
    title: Annotated[str, Field(min_length=1, max_length=200)]
    about: Annotated[str, Field(max_length=4000)] = ""
    seed: Annotated[int, Field(ge=0, lt=2**63)] = 0
    board_views: Annotated[int, Field(ge=3, le=100)] = 20
    gauge_lengths_mm: Annotated[tuple[GaugeLength, ...], Field(max_length=8), FROM_LIST] = (40.0, 30.0, 10.0, 5.0)
    gauge_placements: Annotated[int, Field(ge=2, le=200)] = 20
    # The drawing; the paper's arm where it is left out. Which way gravity pulls is the bench's to say.
    arm: ArmTable | None = None
    geometry: GeometryTable = GeometryTable()
    bench: BenchTable = BenchTable()
    camera: CameraTable = CameraTable()
    picture: PictureTable = PictureTable()
    trajectories: Annotated[dict[Name, Path2d], Field(min_length=2, max_length=20)]
    validate_on: Name = "line"
    obstacles: Annotated[tuple[ObstacleTable, ...], Field(max_length=20), FROM_LIST] = ()
    effects: Annotated[tuple[EffectTable, ...], Field(max_length=100), FROM_LIST] = ()

    # What a film of the moving arm shows; poses at rest do not.
    moving_effects: Annotated[tuple[EffectTable, ...], Field(max_length=100), FROM_LIST] = ()

    @field_validator("effects", "moving_effects", mode="before")
    @classmethod
    def _gather_parameters(cls, tables: Any) -> Any:
        """Let an effect's parameters stand beside its name in the file."""
        return [_gathered(table) for table in tables] if isinstance(tables, list) else tables

    @model_validator(mode="after")
    def _validation_is_a_trajectory(self) -> ScenarioFile:
        if self.validate_on not in self.trajectories:
            raise ValueError(
                f"validate_on names trajectory '{self.validate_on}', which is not declared"
                + nearest(self.validate_on, self.trajectories)
            )
        return self

    @model_validator(mode="after")
    def _geometry_is_of_the_arm(self) -> ScenarioFile:
        arm = self.drawn_arm
        for key, wanted in (("length_errors_mm", len(arm.link_lengths_mm)), ("joint_errors_rad", arm.n_joints)):
            found = len(getattr(self.geometry, key))
            if found not in (0, wanted):
                raise ValueError(f"geometry.{key} needs {wanted} entries for arm '{arm.name}', found {found}")
        return self

    @property
    def drawn_arm(self) -> Arm:
        """The arm as it is drawn."""
        return nominal_arm() if self.arm is None else arm_from_table(self.arm)

    @property
    def calibrate_on(self) -> tuple[str, ...]:
        """Trajectories to calibrate on: all but the validation's, in their order."""
        return tuple(name for name in self.trajectories if name != self.validate_on)

    @property
    def n_poses(self) -> int:
        """Poses of a run: every trajectory, then the validation's twice more."""
        names = [*self.trajectories, self.validate_on, self.validate_on]
        return sum(self.trajectories[name].samples for name in names)

    @cached_property
    def fingerprint(self) -> str:
        """A digest of everything that decides the run's results."""
        text = json.dumps(self.model_dump(mode="json", by_alias=True), sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:16]


def builtin_scenarios() -> dict[str, Path]:
    """Return the scenarios that come with armtwin, by name."""
    return {path.stem: path for path in sorted(FILES.glob("*.toml"))}


def read_scenario(name_or_path: str) -> ScenarioFile:
    """Read a built-in scenario by name, or a scenario or twin file by path; raises `InputError` with file and key."""
    known = builtin_scenarios()
    path = known.get(name_or_path, Path(name_or_path))
    if not path.is_file():
        kind = "such file" if path.suffix == ".toml" else "such scenario or file"
        raise InputError(f"{name_or_path}: no {kind}{nearest(name_or_path, known)}")
    if path.stat().st_size > _MAX_BYTES:
        raise InputError(f"{path.name}: larger than {_MAX_BYTES} bytes, no scenario")
    try:
        data = tomllib.loads(path.read_text("utf-8-sig"))
    except (ValueError, RecursionError) as error:  # no TOML, no UTF-8, a whole number of thousands of digits
        raise InputError(f"{path.name}: not TOML ({error})") from None
    if str(data.get("schema")).startswith("armtwin.twin/"):
        data = scenario_table(read_twin(path), path.name)
    return check_scenario(data, path.name)


def check_scenario(data: object, file: str) -> ScenarioFile:
    """Validate a scenario's tables, its effects against the catalogue and its paths against the arm's reach."""
    scenario = check(ScenarioFile, data, file)
    for name, path in scenario.trajectories.items():
        try:
            inverse(scenario.drawn_arm, path.poses())
        except UnreachablePoseError as error:
            raise InputError(f"{file}: trajectories.{name}: {error}") from None
    for number, effect in enumerate(scenario.effects):
        _check_effect(effect, row("effects", number), scenario, file)
    for number, effect in enumerate(scenario.moving_effects):
        _check_moving_effect(effect, row("moving_effects", number), scenario, file)
    return scenario


def _check_effect(effect: EffectTable, place: str, scenario: ScenarioFile, file: str) -> None:
    """Check an effect's parameters one by one, and then together by building it into an ideal bench."""
    try:
        known = effect_named(effect.name)
    except InputError as error:
        raise InputError(f"{file}: {place}: name: {error}") from None
    arm = scenario.drawn_arm
    try:
        known.check(Stated(effect.parameters, effect.site, f"{place}: "), arm, scenario.n_poses)
    except InputError as error:
        raise InputError(f"{file}: {error}") from None
    world = ideal_world(arm, nominal_camera(), BenchTable().arm_plane_z_mm)
    try:
        known.inject(world, effect.parameters, effect.site)
    except InputError as error:
        raise InputError(f"{file}: {place}: {error}") from None


def _check_moving_effect(effect: EffectTable, place: str, scenario: ScenarioFile, file: str) -> None:
    """Check what a film shows by making it in the world of an ideal arm."""
    try:
        inject_in_motion(
            ideal_motion_world(planar_arm(scenario.drawn_arm)), effect.name, effect.parameters, effect.site
        )
    except InputError as error:
        raise InputError(f"{file}: {place}: {error}") from None


def _gathered(table: Any) -> Any:
    if not isinstance(table, dict) or "parameters" in table:
        return table
    own = {key: value for key, value in table.items() if key in ("name", "joint", "marker")}
    return own | {"parameters": {key: value for key, value in table.items() if key not in own}}
