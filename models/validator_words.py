"""What a file's value should have been, in people's words instead of the validator's."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

_WANTED = {
    "float_type": "a number is wanted",
    "float_parsing": "a number is wanted",
    "finite_number": "a finite number is wanted",
    "int_type": "a whole number is wanted",
    "int_parsing": "a whole number is wanted",
    "int_parsing_size": "a smaller whole number is wanted",
    "int_from_float": "a whole number is wanted",
    "bool_type": "true or false is wanted",
    "bool_parsing": "true or false is wanted",
    "string_type": "a text in quotes is wanted",
    "list_type": "a list in brackets is wanted",
    "tuple_type": "a list in brackets is wanted",
    "dict_type": "a table of keys and values is wanted",
    "model_type": "a table of keys and values is wanted",
    "model_attributes_type": "a table of keys and values is wanted",
    "greater_than": "more than {gt:g} is wanted",
    "greater_than_equal": "at least {ge:g} is wanted",
    "less_than": "less than {lt:g} is wanted",
    "less_than_equal": "at most {le:g} is wanted",
    "string_too_short": "at least {min_length} characters are wanted",
    "string_too_long": "at most {max_length} characters are wanted",
    "string_pattern_mismatch": "a text of the form {pattern} is wanted",
    "too_short": "at least {min_length} entries are wanted, {actual_length} are there",
    "too_long": "at most {max_length} entries are wanted, {actual_length} are there",
    "literal_error": "{expected} is wanted",
    "enum": "{expected} is wanted",
    "union_tag_invalid": "one of {expected_tags} is wanted for {discriminator}",
    "union_tag_not_found": "key {discriminator} is missing, which says of what kind it is",
}


def in_words(kind: str, message: str, context: Mapping[str, Any]) -> str:
    """Return what was wanted, for a validator's error of this kind; its own message where the kind is not known."""
    known = _WANTED.get(kind)
    if known is None:
        return message.removeprefix("Value error, ")
    try:
        return known.format_map(context)
    except (KeyError, ValueError):  # another release of the validator says other things
        return message
