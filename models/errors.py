"""The small tree of errors: what the user can mend (exit code 2), and what went wrong in a job (exit code 1)."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Sequence

# Names that one line may list; the catalogue of effects is shorter.
_MOST_NAMES = 40
# Characters that a message repeats of what a file holds: more than any name of this project has.
_LONGEST_ECHO = 80


class ArmtwinError(Exception):
    """Base of every error that armtwin raises on purpose; the command line prints it as one line."""

    exit_code = 1


class JobError(ArmtwinError):
    """The job could not be done although its input was right (exit code 1)."""


class InputError(ArmtwinError):
    """The input is wrong (exit code 2). The message names the file and key, what was found and what was wanted."""

    exit_code = 2


class UnreachablePoseError(InputError):
    """A pose of the end effector lies outside the arm's reach."""


class RecordingError(InputError):
    """A recording folder breaks its contract."""


def shown(text: str) -> str:
    """Return a text of the user's as a message repeats it, cut off where it is long."""
    return text if len(text) <= _LONGEST_ECHO else text[: _LONGEST_ECHO - 3] + "..."


def nearest(name: str, valid: Iterable[str]) -> str:
    """Return "; did you mean 'x'?" for the valid name nearest to `name`, or a list of the valid names."""
    names = sorted(valid)
    by_lower = {valid_name.lower(): valid_name for valid_name in names}
    close = difflib.get_close_matches(name.lower(), by_lower, n=1)
    if close:
        return f"; did you mean '{shown(by_lower[close[0]])}'?"
    return f"; valid names are {listed(names)}"


def listed(names: Sequence[str]) -> str:
    """Return names as a message repeats them: the first ones, and how many more there are."""
    more = f" and {len(names) - _MOST_NAMES} more" if len(names) > _MOST_NAMES else ""
    return f"{', '.join(map(shown, names[:_MOST_NAMES]))}{more}"
