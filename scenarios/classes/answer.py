"""What a student hands in: cause, place, size with its interval, and commands of a corrected line."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, model_validator

from armtwin.models.validation import Finite, Strict

NOTHING = "none"
Angle = Annotated[float, Field(ge=-7.0, le=7.0, allow_inf_nan=False)]
# Few points make no line, and nobody needs more.
FEWEST_POINTS, MOST_POINTS = 5, 200


class Answer(Strict):
    """An answer: `cause` is an effect's name or `none`; the rest may be left out, which costs its points.

    `parameter` is the name of one of the effect's parameters, with its unit, `value` its size, `low` and `high` the
    ends of an interval that you would bet on 19 to 1. `line_q_cmd_rad` are commands (N, 3) that bring the tip along
    the paper's line, N points evenly spaced from (-145, 25) mm to (-115, 45) mm.
    """

    cause: Annotated[str, Field(min_length=1, max_length=60)]
    joint: Annotated[int, Field(ge=1, le=6)] | None = None
    marker: Annotated[str, Field(max_length=1)] | None = None
    parameter: Annotated[str, Field(max_length=60)] | None = None
    value: Finite | None = None
    low: Finite | None = None
    high: Finite | None = None
    line_q_cmd_rad: (
        Annotated[
            list[Annotated[list[Angle], Field(min_length=1, max_length=6)]],
            Field(min_length=FEWEST_POINTS, max_length=MOST_POINTS),
        ]
        | None
    ) = None
    argument: Annotated[str, Field(max_length=5000)] = ""

    @model_validator(mode="after")
    def _interval_holds_the_value(self) -> Answer:
        ends = (self.low, self.high)
        if (self.low is None) != (self.high is None):
            raise ValueError("an interval has two ends: low and high")
        if None not in ends and self.value is None:
            raise ValueError("an interval without a value; give the value too")
        if self.low is not None and self.high is not None and self.value is not None:
            low, high = self.low, self.high
            if not low <= self.value <= high:
                raise ValueError(f"value {self.value:g} is not between low {low:g} and high {high:g}")
        if self.value is not None and self.parameter is None:
            raise ValueError("a value of what? name the parameter")
        if self.line_q_cmd_rad is not None and len({len(q) for q in self.line_q_cmd_rad}) > 1:
            raise ValueError("line_q_cmd_rad: every row has one angle a joint")
        return self
