"""What files must hold: pydantic models of the arm and camera tables, and one-line messages for what breaks them."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal, TypeVar, get_args, get_origin

import numpy as np
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError, field_validator, model_validator

from armtwin.models.arm_form import MOST_JOINTS, form_named
from armtwin.models.errors import InputError, nearest, shown
from armtwin.models.lenses import lens_named
from armtwin.models.validator_words import in_words

Model = TypeVar("Model", bound=BaseModel)
# No measure of an arm on a table comes near it in any unit; beyond about 1e150 the square of a number overflows.
_LARGEST = 1e9
Finite = Annotated[float, Field(ge=-_LARGEST, le=_LARGEST, allow_inf_nan=False)]
Positive = Annotated[float, Field(gt=0, le=_LARGEST, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0, le=_LARGEST, allow_inf_nan=False)]

# What an arm on a table may have: beyond these its physics cannot be simulated either.
HEAVIEST_KG = 20.0
Length = Annotated[float, Field(ge=0, le=10_000.0, allow_inf_nan=False)]
Mass = Annotated[float, Field(ge=0, le=HEAVIEST_KG, allow_inf_nan=False)]
Gravity = Annotated[float, Field(ge=-100.0, le=100.0, allow_inf_nan=False)]
# What the built arm may differ by from the drawing: beyond these it is another arm.
LengthError = Annotated[float, Field(ge=-1000.0, le=1000.0, allow_inf_nan=False)]
JointError = Annotated[float, Field(ge=-2 * math.pi, le=2 * math.pi, allow_inf_nan=False)]

# No arm on a table is shorter than this; a longest link below it was given in metres.
_SHORTEST_ARM_MM = 2.0
# A link without length has no direction: what turns it cannot be seen.
_SHORTEST_LINK_MM = 0.1
# Table 2 prints its rotation with four digits, so its rows are orthonormal to about 2e-4.
_ROTATION_TOLERANCE = 2e-3


# Files know lists only; what such a tuple holds stays strict.
FROM_LIST = Field(strict=False)


def _without_point(value: object) -> object:
    """Return a whole number that was written with a decimal point as an int: JSON does not tell the two apart."""
    return int(value) if isinstance(value, float) and value.is_integer() else value


class Strict(BaseModel):
    """A table of a file: unknown keys are refused, and so are values of another type (a text or `true` for a number).

    An int passes for a float. Fields that are tuples need `FROM_LIST`.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


# As URDF and ROS name joints; it stands in messages and exported files.
JointName = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_. -]{0,60}$")]


class ArmTable(Strict):
    """The `arm` table of a recording or an arm file."""

    name: Annotated[str, Field(min_length=1, max_length=100)]
    link_lengths_mm: Annotated[list[Length], Field(min_length=1, max_length=7)]
    gravity_m_s2: Annotated[list[Gravity], Field(min_length=2, max_length=2)] = [0.0, 0.0]
    link_masses_kg: list[Mass] | None = None
    tip_mass_kg: Mass | None = None
    joints: list[JointName] | None = None
    joint_limits_rad: list[Annotated[list[Finite], Field(min_length=2, max_length=2)]] | None = None

    @model_validator(mode="after")
    def _joints_have_names_and_limits(self) -> ArmTable:
        n = form_named(self.name).joints_of(len(self.link_lengths_mm))
        for key in ("joints", "joint_limits_rad"):
            given = getattr(self, key)
            if given is not None and len(given) != n:
                raise ValueError(f"{key} needs {n} entries, one a joint, found {len(given)}")
        twice = [name for name in self.joints or () if (self.joints or []).count(name) > 1]
        if twice:
            raise ValueError(f"joints: two of them are called '{twice[0]}'")
        for number, (low, high) in enumerate(self.joint_limits_rad or (), start=1):
            if not low < high:
                raise ValueError(
                    f"joint_limits_rad of joint {number}: found {low:g} to {high:g}, lowest first is wanted"
                )
        return self

    @model_validator(mode="after")
    def _lengths_and_masses_fit(self) -> ArmTable:
        n = len(self.link_lengths_mm)
        form = form_named(self.name)
        joints = form.joints_of(n)
        if form.n_joints is not None and joints != form.n_joints:
            wanted = [f"l{number}" for number in form.length_numbers(n)]
            raise ValueError(
                f"link_lengths_mm of {self.name} needs {len(wanted)} entries ({', '.join(wanted)}), found {n}"
            )
        if not 1 <= joints <= MOST_JOINTS:
            raise ValueError(f"link_lengths_mm holds {n} entries, an arm has 1 to {MOST_JOINTS} joints")
        if max(self.link_lengths_mm) < _SHORTEST_ARM_MM:
            raise ValueError(
                f"link_lengths_mm has a longest link of {max(self.link_lengths_mm):g} mm; "
                "lengths are in mm, these look like metres: multiply by 1000"
            )
        links = self.link_lengths_mm
        if form.tip_offset:
            links = [*links[:-2], math.hypot(*links[-2:])]
        short = [k for k, length in enumerate(links) if length < _SHORTEST_LINK_MM]
        if short:
            raise ValueError(
                f"link_lengths_mm: found {self.link_lengths_mm[short[0]]:g} for link {short[0] + 1}, "
                f"at least {_SHORTEST_LINK_MM:g} is wanted"
            )
        if self.link_masses_kg is not None and len(self.link_masses_kg) != joints:
            raise ValueError(f"link_masses_kg needs {joints} entries, one a link, found {len(self.link_masses_kg)}")
        return self


class ArmFile(ArmTable):
    """An arm file: the arm table with its schema."""

    schema_: Literal["armtwin.arm/1"] = Field(alias="schema")


ImageSize = Annotated[int, BeforeValidator(_without_point), Field(ge=16, le=20000)]


class CameraTable(Strict):
    """The `camera` table of a recording."""

    image_width: ImageSize
    image_height: ImageSize
    camera_matrix: list[list[Finite]]
    distortion_model: Annotated[str, Field(max_length=100)] = "plumb_bob"
    distortion_coefficients: Annotated[list[Finite], Field(max_length=14)]
    board_to_camera_rotation: list[list[Finite]]
    board_to_camera_translation_mm: Annotated[list[Finite], Field(min_length=3, max_length=3)]

    @field_validator("camera_matrix", "board_to_camera_rotation")
    @classmethod
    def _is_three_by_three(cls, rows: list[list[float]]) -> list[list[float]]:
        if [len(row) for row in rows] != [3, 3, 3]:
            raise ValueError("must be a 3x3 matrix, a list of three rows of three numbers")
        return rows

    @model_validator(mode="after")
    def _is_a_camera(self) -> CameraTable:
        K = np.array(self.camera_matrix)
        if K[0, 0] < 1 or K[1, 1] < 1 or abs(K[2] - [0, 0, 1]).max() > 1e-9 or K[1, 0] != 0:
            raise ValueError(
                "camera_matrix must be [[fx, s, cx], [0, fy, cy], [0, 0, 1]] with fx, fy > 0 in pixels, at least 1"
            )
        try:
            lens_named(self.distortion_model, self.distortion_coefficients)
        except InputError as error:
            raise ValueError(str(error)) from None
        R = np.array(self.board_to_camera_rotation)
        off = abs(R @ R.T - np.eye(3)).max()
        if off > _ROTATION_TOLERANCE or np.linalg.det(R) < 0:
            raise ValueError(
                f"board_to_camera_rotation is no rotation (R R' is off by {off:.2g}, determinant "
                f"{np.linalg.det(R):.3f}); give the orthonormal matrix that maps board to camera axes"
            )
        if np.linalg.norm(self.board_to_camera_translation_mm) < _SHORTEST_ARM_MM:
            raise ValueError("board_to_camera_translation_mm is in mm; this looks like metres: multiply by 1000")
        return self


def check(model: type[Model], data: object, file: str) -> Model:
    """Validate `data` as `model`; raises `InputError` with the file, the key, what was found and what was wanted."""
    try:
        return model.model_validate(data)
    except ValidationError as error:
        raise InputError(_one_line(model, error, file)) from None


def row(key: str, index: int) -> str:
    """Return what people call a row of a list of tables, `index` from 0: 'joint 2' for the second of `joints`."""
    return f"{key.removesuffix('s')} {index + 1}"


def _one_line(model: type[BaseModel], error: ValidationError, file: str) -> str:
    # A misspelt key is also a missing one: the misspelling is what helps.
    errors = sorted(error.errors(include_url=False), key=lambda e: e["type"] != "extra_forbidden")
    first = errors[0]
    place, keys, tables = _walk(model, first["loc"])
    key = ".".join(keys)
    more = f" (and {error.error_count() - 1} more)" if error.error_count() > 1 else ""
    if first["type"] == "extra_forbidden":
        hint = nearest(keys[-1], {field.alias or name for t in tables for name, field in t.model_fields.items()})
        return ": ".join([file, *place, f"unknown key '{key}'{hint}{more}"])
    if first["type"] == "missing":
        return ": ".join([file, *place, f"key '{key}' is missing{more}"])
    message = in_words(first["type"], first["msg"], first.get("ctx") or {})
    found = "" if first["type"] == "value_error" else f", found {short(first.get('input'))}"
    return ": ".join([file, *place, *([key] if key else []), f"{message}{found}{more}"])


def _walk(
    model: type[BaseModel], location: tuple[int | str, ...]
) -> tuple[list[str], list[str], list[type[BaseModel]]]:
    """Return the rows of lists that lead to a place, the keys behind them, and the tables that the last may stand in.

    Rows are counted from 1, as people do; keys are spelt as in the file. Pydantic's location also holds the tag of a
    table that is one of several kinds; the file does not.
    """
    place: list[str] = []
    keys: list[str] = []
    tables: list[type[BaseModel]] = [model]
    of_tables = named = False  # the next part is a row of a list of tables; a name of a dictionary
    for number, part in enumerate(location):
        last = number == len(location) - 1
        fields = {name: field for t in tables for n, field in t.model_fields.items() for name in (n, field.alias)}
        tagged = [t for t in tables if any(part in get_args(f.annotation) for f in t.model_fields.values())]
        if isinstance(part, int):
            rows = ".".join(keys)
            place, keys = [*place, row(rows, part) if of_tables else f"{rows} entry {part + 1}".strip()], []
        elif named:
            keys.append(shown(part))
            named = False
        elif part in fields:
            keys.append(part)
            annotation = fields[part].annotation
            named = get_origin(annotation) is dict
            of_tables = bool(_tables_in(annotation))
            tables = tables if last else _tables_in(annotation)
        elif tagged and not last:
            tables = tagged
        else:
            keys.append(shown(part))
    return place, keys, tables


def _tables_in(annotation: Any) -> list[type[BaseModel]]:
    """List the tables that a field's type mentions: of a list, a dictionary, a choice of several."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [table for argument in get_args(annotation) for table in _tables_in(argument)]


def short(value: object) -> str:
    """Return a value as it is shown in a message, cut off where it is long."""
    return shown(repr(value))
