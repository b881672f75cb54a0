"""Sealed worlds: what a set holds, that it gives nothing away, and that it can be gone on with."""

from __future__ import annotations

import json
import re
from collections import Counter
from pathlib import Path

import pytest

from armtwin.models.errors import InputError
from armtwin.models.folder_lock import only_writer
from armtwin.models.recordings.reader import read_recording
from armtwin.scenarios.cli import main
from armtwin.scenarios.scoring.orders import SealOptions, orders
from armtwin.scenarios.scoring.sealing import read_truth, seal, world_folder
from armtwin.sim.sealed import STRENGTHS, sealed_effects

UNCATALOGUED = Path(__file__).parents[1] / "support" / "uncatalogued.py"
FEW = SealOptions(n=2, seed=4, effects=("none", "servo_gain"))


@pytest.fixture(scope="module")
def few(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a set of one world that hides a wrong gain and one that hides nothing."""
    out = tmp_path_factory.mktemp("sealed") / "few"
    assert sorted(seal(out, FEW, jobs=1)) == [0, 1]
    return out


def test_a_set_hides_every_effect_and_in_a_tenth_of_the_worlds_nothing() -> None:
    made = orders(SealOptions(n=80, seed=1))
    assert Counter(order.kind for order in made) == {"single": 72, "null": 8}
    assert {name for order in made for name in order.effects} == set(sealed_effects())


def test_each_effect_is_hidden_at_each_strength() -> None:
    made = [order for order in orders(SealOptions(n=80, seed=1)) if order.kind == "single"]
    assert {(order.effects[0], order.strength) for order in made} == {
        (e, s) for e in sealed_effects() for s in STRENGTHS
    }


def test_the_number_of_a_world_says_nothing_of_what_it_hides() -> None:
    first, second = (orders(SealOptions(n=60, seed=seed)) for seed in (1, 2))
    assert [order.effects for order in first] != [order.effects for order in second]


def test_pairs_are_of_effects_that_are_not_taken_for_each_other() -> None:
    made = orders(SealOptions(n=100, seed=3, pairs=True))
    pairs = [set(order.effects) for order in made if order.kind == "pair"]
    assert len(pairs) == 20
    assert {"backlash", "hysteresis"} not in pairs
    assert all(len(pair) == 2 for pair in pairs)


def test_a_set_can_hold_faults_that_no_effect_describes() -> None:
    made = orders(SealOptions(n=100, seed=3, uncatalogued=str(UNCATALOGUED)))
    strange = {order.effects[0] for order in made if order.kind == "uncatalogued"}
    assert len(strange) >= 5
    assert not strange & set(sealed_effects())


def test_only_the_wanted_effects_are_hidden() -> None:
    made = orders(SealOptions(n=6, seed=3, effects=("backlash", "joint_slip")))
    assert {order.effects for order in made} == {("backlash",), ("joint_slip",)}


def test_an_unknown_effect_is_refused_with_the_nearest_name() -> None:
    with pytest.raises(InputError, match=r"backlush.*backlash"):
        orders(SealOptions(n=6, seed=3, effects=("backlush",)))


def test_the_recordings_read_back_and_the_truth_stands_apart(few: Path) -> None:
    truth = read_truth(few)["worlds"]
    assert sorted(truth) == ["0000", "0001"]
    assert sorted(len(world["effects"]) for world in truth.values()) == [0, 1]
    for name, world in truth.items():
        recording = read_recording(world_folder(few, int(name)))
        assert len(recording) == world["n_poses"]
        assert recording.held_out


def test_a_recording_gives_neither_effect_nor_seed_nor_truth_away(few: Path) -> None:
    for folder in (few / "worlds").iterdir():
        assert sorted(path.name for path in folder.iterdir()) == ["recording.json", "samples.csv"]
        header = json.loads((folder / "recording.json").read_text())
        assert set(header) <= {"schema", "arm", "camera", "arm_plane_z_mm", "pixel_noise_px", "held_out"}
        text = (folder / "recording.json").read_text() + (folder / "samples.csv").read_text()
        assert not [name for name in (*sealed_effects(), "seed", "effect") if name in text]


def test_what_is_hidden_moves_the_markers_by_three_noises_at_least(few: Path) -> None:
    hidden = [effect for world in read_truth(few)["worlds"].values() for effect in world["effects"]]
    assert all(effect["moved_noises"] >= 3.0 for effect in hidden)


def test_the_same_seed_makes_the_same_recordings(few: Path, tmp_path: Path) -> None:
    list(seal(tmp_path / "again", FEW, jobs=1))
    for index in range(2):
        a, b = (world_folder(out, index) / "samples.csv" for out in (few, tmp_path / "again"))
        assert a.read_bytes() == b.read_bytes()


def test_a_finished_set_is_not_made_again(few: Path) -> None:
    assert list(seal(few, FEW, jobs=1)) == []


def test_a_set_that_broke_off_is_gone_on_with(few: Path, tmp_path: Path) -> None:
    out = tmp_path / "broken_off"
    making = seal(out, FEW, jobs=1)
    first = next(making)
    making.close()
    assert set(seal(out, FEW, jobs=1)) == {0, 1} - {first}
    assert read_truth(out)["worlds"] == read_truth(few)["worlds"]


def test_a_set_killed_in_its_first_world_is_gone_on_with(few: Path, tmp_path: Path) -> None:
    first = seal(tmp_path / "out", FEW, jobs=1)
    next(first)
    first.close()
    truth = tmp_path / "out" / "truth.json"
    truth.write_text(json.dumps({**json.loads(truth.read_text()), "worlds": {}}))  # as it is begun
    (tmp_path / "out" / "worlds" / ".0001.abc.part").mkdir()
    assert sorted(seal(tmp_path / "out", FEW, jobs=1)) == [0, 1]
    assert read_truth(tmp_path / "out") == read_truth(few)
    assert not list(tmp_path.rglob(".*"))


def test_a_folder_of_another_set_is_refused(few: Path) -> None:
    with pytest.raises(InputError, match="other options"):
        list(seal(few, SealOptions(n=2, seed=5), jobs=1))


def test_a_folder_in_which_another_set_is_being_made_is_refused(few: Path) -> None:
    with only_writer(few), pytest.raises(InputError, match="another armtwin is at work there"):
        list(seal(few, FEW, 1))


def test_a_folder_that_holds_something_else_is_refused(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(InputError, match="not empty"):
        list(seal(tmp_path, FEW, jobs=1))


@pytest.mark.slow
def test_frames_are_rendered_and_measured(tmp_path: Path) -> None:
    out = tmp_path / "filmed"
    list(seal(out, SealOptions(n=1, seed=2, frames=True, effects=("none",)), jobs=1))
    recording = read_recording(world_folder(out, 0))
    assert len(list((world_folder(out, 0) / "frames").glob("*.png"))) == len(recording)
    assert recording.pixel_noise_px is not None
    assert recording.pixel_noise_px < 0.3  # a sub-pixel detector's, not the noise that was drawn for bare pixels


def test_an_unknown_effect_ends_the_command_with_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as left:
        main(["seal", "--effects", "backlush", "--out", str(tmp_path / "out")])
    assert left.value.code == 2
    assert len(capsys.readouterr().err.splitlines()) == 1
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("world", ["../elsewhere", "one", "\u0663"])
def test_a_world_that_names_no_folder_of_the_set_is_refused(tmp_path: Path, world: str) -> None:
    table = {"schema": "armtwin.sealed/1", "options": {}, "worlds": {world: {}}}
    (tmp_path / "truth.json").write_text(json.dumps(table))
    with pytest.raises(InputError, match="a number such as 0007 is wanted"):
        read_truth(tmp_path)


@pytest.mark.parametrize(
    ("world", "said"),
    [
        (5, "worlds.0000: a table of keys and values is wanted, found 5"),
        ({"effects": None}, "worlds.0000: effects: "),
        ({"effects": [{"effect": "backlash"}]}, "worlds.0000: effect 1: key 'joint' is missing"),
        ({"noise_px": 0}, "worlds.0000: noise_px: "),
    ],
)
def test_a_truth_that_the_score_cannot_read_is_refused(few: Path, tmp_path: Path, world: object, said: str) -> None:
    table = json.loads((few / "truth.json").read_text())
    table["worlds"]["0000"] = table["worlds"]["0000"] | world if isinstance(world, dict) else world
    (tmp_path / "truth.json").write_text(json.dumps(table))
    with pytest.raises(InputError, match=re.escape(f"truth.json: {said}")):
        read_truth(tmp_path)


def test_a_set_without_its_options_is_not_gone_on_with(few: Path, tmp_path: Path) -> None:
    table = json.loads((few / "truth.json").read_text())
    del table["options"]
    (tmp_path / "truth.json").write_text(json.dumps(table))
    with pytest.raises(InputError, match=r"truth\.json: options: a table of keys and values is wanted"):
        list(seal(tmp_path, FEW, jobs=1))


def test_a_file_of_faults_that_does_not_run_is_refused(tmp_path: Path) -> None:
    (tmp_path / "faults.py").write_text("def broken(:")
    with pytest.raises(InputError, match="does not run: SyntaxError"):
        orders(SealOptions(n=2, seed=0, uncatalogued=str(tmp_path / "faults.py")))
