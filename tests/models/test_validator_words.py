"""Messages about files speak to people: no word of the validator's is left."""

from __future__ import annotations

from typing import Annotated, Literal

import pytest
from pydantic import Field

from armtwin.models.errors import InputError
from armtwin.models.validation import FROM_LIST, Strict, check


class Inner(Strict):
    width_mm: float = 1.0


class Circle(Strict):
    kind: Literal["circle"]


class Line(Strict):
    kind: Literal["line"]


class Everything(Strict):
    number: float = 0.0
    whole: int = 0
    yes: bool = True
    text: Annotated[str, Field(min_length=2, max_length=4, pattern="^[a-z]*$")] = "ab"
    bounded: Annotated[float, Field(gt=0, lt=9, allow_inf_nan=False)] = 1.0
    closed: Annotated[float, Field(ge=0, le=9)] = 1.0
    pair: Annotated[list[float], Field(min_length=2, max_length=2)] = [0.0, 0.0]  # noqa: RUF012 (a model's default)
    fixed: Annotated[tuple[float, float], FROM_LIST] = (0.0, 0.0)
    word: Literal["left", "right"] = "left"
    inner: Inner = Inner()
    path: Annotated[Circle | Line, Field(discriminator="kind")] = Circle(kind="circle")


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("number", "1", "number: a number is wanted, found '1'"),
        ("whole", 1.5, "whole: a whole number is wanted, found 1.5"),
        ("yes", 1, "yes: true or false is wanted, found 1"),
        ("text", 5, "text: a text in quotes is wanted, found 5"),
        ("text", "a", "text: at least 2 characters are wanted, found 'a'"),
        ("text", "abcde", "text: at most 4 characters are wanted, found 'abcde'"),
        ("text", "AB", "text: a text of the form ^[a-z]*$ is wanted, found 'AB'"),
        ("bounded", 0, "bounded: more than 0 is wanted, found 0"),
        ("bounded", 9, "bounded: less than 9 is wanted, found 9"),
        ("bounded", float("inf"), "bounded: a finite number is wanted, found inf"),
        ("closed", -1, "closed: at least 0 is wanted, found -1"),
        ("closed", 10, "closed: at most 9 is wanted, found 10"),
        ("pair", 3, "pair: a list in brackets is wanted, found 3"),
        ("pair", [1.0], "pair: at least 2 entries are wanted, 1 are there, found [1.0]"),
        ("word", "up", "word: 'left' or 'right' is wanted, found 'up'"),
        ("inner", 3, "inner: a table of keys and values is wanted, found 3"),
        ("path", {"kind": "arc"}, "path: one of 'circle', 'line' is wanted for 'kind', found {'kind': 'arc'}"),
        ("path", {}, "path: key 'kind' is missing, which says of what kind it is, found {}"),
    ],
)
def test_what_was_wanted_is_said_in_words(key: str, value: object, message: str) -> None:
    with pytest.raises(InputError) as refused:
        check(Everything, {key: value}, "file.toml")
    assert str(refused.value) == f"file.toml: {message}"


@pytest.mark.parametrize("value", [[1.0], [1.0, 2.0, 3.0], "ab", None])
def test_no_word_of_the_validators_own_is_left(value: object) -> None:
    with pytest.raises(InputError) as refused:
        check(Everything, {"fixed": value}, "file.toml")
    assert "Input should" not in str(refused.value)
