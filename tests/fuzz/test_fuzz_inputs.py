"""A few hundred spoilt files of every kind; `make fuzz-inputs` tries thousands."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tests.fuzz.fuzz_inputs import FIXED_SEED, fuzz
from tests.fuzz.kinds import make_kinds
from tests.fuzz.mutations import mutated


def test_a_spoilt_file_of_any_kind_is_answered_in_one_line(tmp_path: Path) -> None:
    assert fuzz(tmp_path, FIXED_SEED, 300) == []


def test_every_good_file_is_read(tmp_path: Path) -> None:
    """Otherwise the spoilt ones would be refused for another reason than what spoils them."""
    for kind in make_kinds(tmp_path):
        if kind.name != "lerobot":  # its header stands for itself; the rows are another file
            kind.read()


def test_a_mutation_changes_its_file_and_comes_again_by_its_seed() -> None:
    data = b'{"a": 1.5, "b": [2, 3]}\n' * 5
    changed = [mutated(data, np.random.default_rng([1, number])) for number in range(50)]
    assert sum(one != data for one in changed) > 40
    assert changed == [mutated(data, np.random.default_rng([1, number])) for number in range(50)]
