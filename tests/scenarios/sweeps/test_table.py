from pathlib import Path

import pytest

from armtwin.models.errors import InputError
from armtwin.scenarios.sweeps.table import cells_of, read_sweep


def _file(folder: Path, factors: str, head: str = "") -> Path:
    path = folder / "sweep.toml"
    path.write_text(f'schema = "armtwin.sweep/1"\n{head}\n[factors]\n{factors}\n', "utf-8")
    return path


def test_factors_are_crossed_in_a_fixed_order(tmp_path: Path) -> None:
    path = _file(tmp_path, 'effects = ["backlash", "dead_band + payload"]\nnoise_px = [0.05, 0.2]\nposes = [50, 100]')
    cells = cells_of(read_sweep(path))
    assert [cell.number for cell in cells] == list(range(8))
    assert cells[0].effects == ("backlash",)
    assert cells[7].effects == ("dead_band", "payload")
    assert (cells[7].noise_px, cells[7].poses) == (0.2, 100)


def test_cells_that_are_drawn_keep_the_numbers_of_the_whole_crossing(tmp_path: Path) -> None:
    path = _file(tmp_path, 'effects = ["all"]\nposes = [50, 100, 200]', head="draw = 10")
    drawn = cells_of(read_sweep(path))
    whole = cells_of(read_sweep(_file(tmp_path, 'effects = ["all"]\nposes = [50, 100, 200]')))
    assert len(drawn) == 10
    assert all(cell == whole[cell.number] for cell in drawn)


@pytest.mark.parametrize(
    ("factors", "said"),
    [
        ('effects = ["backlsh"]', "did you mean 'backlash'"),
        ('motion = ["moving"]', "only 'settled' worlds can be swept"),
        ('places = ["elbow"]', "joint 2 or marker b is wanted"),
        ('markers = ["a"]', "at least two letters"),
        ("noise = [0.1]", "did you mean 'noise_px'"),
        ("poses = [3]", "found 3"),
    ],
)
def test_a_wrong_factor_is_refused_in_one_line(tmp_path: Path, factors: str, said: str) -> None:
    with pytest.raises(InputError, match=said) as refused:
        read_sweep(_file(tmp_path, factors))
    assert "\n" not in str(refused.value)
