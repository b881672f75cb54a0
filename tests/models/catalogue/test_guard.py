"""What a person's own effect gets wrong is told with its file's name."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from armtwin.models.catalogue import registry
from armtwin.models.catalogue.predict import Active, joint_angles
from armtwin.models.catalogue.reference import reference_context
from armtwin.models.catalogue.registry import Site, register_file
from armtwin.models.errors import InputError

FILE = """
from dataclasses import replace
import numpy as np
from armtwin.models.catalogue.registry import effect_named

def term(context, q, values, site):
    {body}

EFFECT = replace(effect_named("servo_gain"), name="{name}", term=term)
"""


@pytest.mark.parametrize(
    ("body", "said"),
    [
        ("return q[:-1]", r"its term returns shape \(149, 3\), angles of shape \(150, 3\) are wanted"),
        ("return q * np.nan", ".*finite angles are wanted"),
        ("return None", "its term returns NoneType"),
        ("q += 1; return q", "its term changes the angles it is given"),
        ("return q + values[7]", "its term raises IndexError: index 7"),
    ],
    ids=["shape", "nan", "none", "in place", "exception"],
)
def test_a_mistake_names_the_file_and_what_is_wrong(
    tmp_path: Path, body: str, said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(registry, "_LOADED", dict(registry.catalogue()))
    path = tmp_path / "mine.py"
    path.write_text(FILE.format(body=body, name="mine"))
    effect = register_file(path)
    with pytest.raises(InputError, match=rf"mine\.py: effect 'mine': {said}"):
        joint_angles(reference_context(), [Active(effect, Site(joint=1), np.array([1.1]))])


def test_an_effect_without_a_mistake_works_as_it_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(registry, "_LOADED", dict(registry.catalogue()))
    path = tmp_path / "mine.py"
    path.write_text(FILE.format(body="return q + values[0]", name="mine"))
    angles = joint_angles(reference_context(), [Active(register_file(path), Site(joint=1), np.array([0.5]))])
    np.testing.assert_array_equal(angles, 0.5)
