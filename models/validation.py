"""What files must hold: pydantic models of the arm and camera tables, and one-line messages for what breaks them."""

from __future__ import annotations

from typing import Annotated, Any, Literal, TypeVar

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_validator, model_validator

from models.errors import InputError, nearest

Model = TypeVar("Model", bound=BaseModel)
Finite = Annotated[float, Field(allow_inf_nan=False)]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]

# No arm on a table is shorter than this; a longest link below it was given in metres.
_SHORTEST_ARM_MM = 2.0
# Table 2 prints its rotation with four digits, so its rows are orthonormal to about 2e-4.
_ROTATION_TOLERANCE = 2e-3


class Strict(BaseModel):
    """A table of a file: unknown keys are refused."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class ArmTable(Strict):
    """The `arm` table of a recording or an arm file."""

    name: Annotated[str, Field(min_length=1, max_length=100)]
    link_lengths_mm: Annotated[list[NotNegative], Field(min_length=1, max_length=7)]
    gravity_m_s2: Annotated[list[Finite], Field(min_length=2, max_length=2)] = [0.0, 0.0]
    link_masses_kg: list[NotNegative] | None = None
    tip_mass_kg: NotNegative | None = None

    @model_validator(mode="after")
    def _lengths_and_masses_fit(self) -> ArmTable:
        n = len(self.link_lengths_mm)
        if self.name == "planar3" and n != 4:
            raise ValueError(f"link_lengths_mm of planar3 needs 4 entries (l1, l2, l4, l5), found {n}")
        if self.name != "planar3" and n > 6:
            raise ValueError(f"link_lengths_mm holds {n} entries, an arm has 1 to 6 joints")
        if max(self.link_lengths_mm) < _SHORTEST_ARM_MM:
            raise ValueError(
                f"link_lengths_mm has a longest link of {max(self.link_lengths_mm):g} mm; "
                "lengths are in mm, these look like metres: multiply by 1000"
            )
        joints = 3 if self.name == "planar3" else n
        if self.link_masses_kg is not None and len(self.link_masses_kg) != joints:
            raise ValueError(f"link_masses_kg needs {joints} entries, one a link, found {len(self.link_masses_kg)}")
        return self


class ArmFile(ArmTable):
    """An arm file: the arm table with its schema."""

    schema_: Literal["armtwin.arm/1"] = Field(alias="schema")


class CameraTable(Strict):
    """The `camera` table of a recording."""

    image_width: Annotated[int, Field(ge=16, le=20000)]
    image_height: Annotated[int, Field(ge=16, le=20000)]
    camera_matrix: list[list[Finite]]
    distortion_model: Literal["plumb_bob"] = "plumb_bob"
    distortion_coefficients: Annotated[list[Finite], Field(min_length=5, max_length=5)]
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
        if K[0, 0] <= 0 or K[1, 1] <= 0 or abs(K[2] - [0, 0, 1]).max() > 1e-9 or K[1, 0] != 0:
            raise ValueError("camera_matrix must be [[fx, s, cx], [0, fy, cy], [0, 0, 1]] with fx, fy > 0 in pixels")
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


def _one_line(model: type[BaseModel], error: ValidationError, file: str) -> str:
    first = error.errors(include_url=False)[0]
    key = ".".join(str(part) for part in first["loc"])
    more = f" (and {error.error_count() - 1} more)" if error.error_count() > 1 else ""
    if first["type"] == "extra_forbidden":
        hint = nearest(str(first["loc"][-1]), _keys_at(model, first["loc"][:-1]))
        return f"{file}: unknown key '{key}'{hint}{more}"
    if first["type"] == "missing":
        return f"{file}: key '{key}' is missing{more}"
    message = first["msg"].removeprefix("Value error, ")
    found = "" if first["type"] == "value_error" else f", found {_short(first.get('input'))}"
    return f"{file}: {f'{key}: ' if key else ''}{message}{found}{more}"


def _keys_at(model: type[BaseModel], location: tuple[int | str, ...]) -> list[str]:
    """List the valid keys of the table that `location` leads to."""
    current: Any = model
    for part in location:
        field = getattr(current, "model_fields", {}).get(part)
        if field is None:
            continue
        arguments = [field.annotation, *getattr(field.annotation, "__args__", ())]
        current = next((a for a in arguments if isinstance(a, type) and issubclass(a, BaseModel)), current)
    return [field.alias or name for name, field in current.model_fields.items()]


def _short(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."
