"""An effect is hidden in the data and has to be found: alone, with others, none, and one that no catalogue has.

Seeds are fixed; with ARMTWIN_FRESH_SEEDS=n, n fresh ones are drawn instead (the nightly run), and each stands in its
test's name, so that a failure can be repeated with ARMTWIN_SEEDS=seed,seed.
"""

from __future__ import annotations

import os
import secrets
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from armtwin.calib.diagnosis.diagnosis import diagnose
from armtwin.models.arm import Arm
from armtwin.models.errors import RecordingError
from armtwin.models.plan import plan_of
from armtwin.models.recordings.recording import Recording
from armtwin.scenarios.scoring.judge import Judgement, judge
from armtwin.scenarios.scoring.outcome import outcome_of
from armtwin.sim.observe import make_angle_recording
from armtwin.sim.sealed import Sealed, Strength, draw_world, sealed_effects
from tests.support.uncatalogued import UNCATALOGUED, draw_uncatalogued
from tests.support.worlds import scattered, there_and_back, upright_world, with_effect

# Poses of a small recording: enough for every effect at medium strength, and quick.
SMALL = 110


def seeds() -> list[int]:
    if given := os.environ.get("ARMTWIN_SEEDS"):
        return [int(seed) for seed in given.split(",")]
    return [secrets.randbits(32) for _ in range(int(os.environ.get("ARMTWIN_FRESH_SEEDS", "0")))] or [20230601]


SEEDS = seeds()
# What is not named yet in the worlds of the fixed seed: a failure that ends is to be taken out here.
NOT_YET = {
    (
        "weak",
        "outliers",
    ): "errors of five noises are left out as the tail of the noise, from which none of 700 points tells them",
}


def told_if_not_yet(request: pytest.FixtureRequest, strength: str, effect: str, seed: int) -> None:
    if seed == 20230601 and (strength, effect) in NOT_YET:
        request.applymarker(pytest.mark.xfail(reason=NOT_YET[strength, effect], strict=True))


def drawn(seed: int, what: str, effects: str | Sequence[str] | None, strength: Strength, **options: Any) -> Sealed:
    """Draw a world by a seed and what it is for, so that no two tests share their draws."""
    rng = np.random.default_rng([seed, *what.encode()])
    return draw_world(rng, effects, strength, **{"n_poses": SMALL, **options})


def answered(kind: str, sealed: Sealed, recording: Recording | None = None) -> Judgement:
    """Diagnose a world (or another recording of it) and judge the answer."""
    diagnosis = diagnose(sealed.recording if recording is None else recording)
    return judge({**sealed.truth, "kind": kind}, {**outcome_of(diagnosis), "seconds": 0.0})


def right(answer: Judgement) -> bool:
    """Whether the effect is named, at its place."""
    return answer.right and answer.site_right == answer.sited


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("effect", sealed_effects())
def test_a_weak_effect_is_named(effect: str, seed: int, request: pytest.FixtureRequest) -> None:
    told_if_not_yet(request, "weak", effect, seed)
    answer = answered("single", drawn(seed, f"weak {effect}", effect, "weak", n_poses=2 * SMALL))
    assert right(answer), answer


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("effect", sealed_effects())
def test_an_effect_is_named(effect: str, seed: int, request: pytest.FixtureRequest) -> None:
    told_if_not_yet(request, "medium", effect, seed)
    # Gross errors are rare single sightings: of twice as many poses enough are gross.
    answer = answered(
        "single", drawn(seed, effect, effect, "medium", n_poses=2 * SMALL if effect == "outliers" else SMALL)
    )
    assert right(answer), answer


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("effect", sealed_effects())
def test_a_strong_effect_is_named(effect: str, seed: int) -> None:
    answer = answered("single", drawn(seed, f"strong {effect}", effect, "strong"))
    assert right(answer), answer


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("noise_px", [0.05, 0.5])
def test_nothing_is_named_where_nothing_is_hidden(seed: int, noise_px: float) -> None:
    answer = answered("null", drawn(seed, f"none {noise_px}", None, "medium", noise_px=noise_px))
    assert answer.said == "none"


PAIRS = [
    ("backlash", "camera_moved"),
    ("gravity_sag", "joint_slip"),
    ("servo_gain", "outliers"),
    ("hysteresis", "lens_distortion"),
    ("dead_band", "camera_tilt"),
]


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("pair", PAIRS, ids=" and ".join)
def test_both_of_two_effects_are_named(pair: tuple[str, str], seed: int) -> None:
    answer = answered("pair", drawn(seed, str(pair), pair, "medium", n_poses=2 * SMALL))
    assert right(answer), answer


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("fault", UNCATALOGUED)
def test_what_no_catalogue_has_is_called_unknown(fault: str, seed: int) -> None:
    sealed = draw_uncatalogued(np.random.default_rng([seed, *fault.encode()]), fault, "strong")
    answer = answered("uncatalogued", sealed)
    assert answer.said == "unknown", answer


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("effect", ["backlash", "servo_gain", "thermal_drift", "camera_tilt", "quantization"])
def test_few_poses_lead_to_no_wrong_name(effect: str, seed: int) -> None:
    answer = answered("single", drawn(seed, f"few {effect}", effect, "strong", n_poses=40))
    assert not answer.wrong, answer


def test_a_recording_too_short_to_decide_is_refused_with_what_is_missing() -> None:
    sealed = drawn(SEEDS[0], "short", None, "medium", markers=("f",))
    with pytest.raises(RecordingError, match="add at least"):
        diagnose(cut(sealed.recording, 8))


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("effect", ["backlash", "servo_gain", "gravity_sag", "camera_moved", "joint_slip"])
def test_heavy_noise_hides_no_strong_effect(effect: str, seed: int) -> None:
    answer = answered("single", drawn(seed, f"noise {effect}", effect, "strong", noise_px=0.8))
    assert right(answer), answer


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("effect", ["backlash", "servo_gain", "gravity_sag", "camera_moved", "joint_slip"])
def test_an_effect_is_named_where_a_third_of_the_markers_is_missing(effect: str, seed: int) -> None:
    answer = answered("single", drawn(seed, f"missing {effect}", effect, "strong", missing=0.33))
    assert right(answer), answer


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("effect", ["backlash", "servo_gain", "gravity_sag", "thermal_drift"])
def test_marker_f_alone_is_enough_as_in_the_paper(effect: str, seed: int) -> None:
    answer = answered("single", drawn(seed, f"f {effect}", effect, "strong", markers=("f",)))
    assert right(answer), answer


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("effect", ["backlash", "joint_slip", "camera_moved", "camera_drift", "servo_gain"])
def test_an_effect_is_named_without_times(effect: str, seed: int) -> None:
    sealed = drawn(seed, f"no time {effect}", effect, "medium", n_poses=2 * SMALL)
    timeless = replace(sealed.recording, time_s=np.full(len(sealed.recording), np.nan))
    answer = answered("single", sealed, timeless)
    assert right(answer), answer


ANGLES = [
    ("backlash", 2, {"width_rad": 0.05}),
    ("servo_gain", 1, {"gain": 1.08}),
    ("quantization", None, {"step_rad": 0.0349}),
    ("joint_slip", 3, {"jump_rad": 0.05, "from_sample": 70}),
]


@pytest.mark.parametrize(("effect", "joint", "parameters"), ANGLES, ids=[row[0] for row in ANGLES])
def test_an_effect_is_named_by_joint_angles_alone(effect: str, joint: int | None, parameters: dict[str, Any]) -> None:
    rng = np.random.default_rng([SEEDS[0], *effect.encode()])
    sweeps = [there_and_back(j, -0.4, 0.4, 12) for j in (1, 2, 3)]
    plan = plan_of({"all": scattered(40, 3), "one": sweeps[0], "two": sweeps[1], "three": sweeps[2]})
    world = with_effect(upright_world(), effect, parameters, joint=joint)
    recording = make_angle_recording(world, plan.q_cmd, plan.trajectory, None, rng, 0.003, held_out=())
    answer = judge(
        {"kind": "single", "effects": [{"effect": effect, "joint": joint, "marker": None, "parameters": parameters}]}
        | {"noise_px": 0.003},
        {**outcome_of(diagnose(recording)), "seconds": 0.0},
    )
    assert right(answer), answer


@pytest.mark.parametrize("n_joints", [1, 2, 4, 6])
@pytest.mark.parametrize("effect", ["servo_gain", "backlash"])
def test_an_effect_is_named_on_an_arm_of_any_number_of_joints(effect: str, n_joints: int) -> None:
    arm = Arm("chain", np.full(n_joints, 150.0 / n_joints), np.zeros(2))
    answer = answered("single", drawn(SEEDS[0], f"{n_joints} {effect}", effect, "strong", arm=arm))
    assert right(answer), answer


def cut(recording: Recording, n: int) -> Recording:
    """Return the first n poses."""
    return replace(
        recording,
        sample=recording.sample[:n],
        time_s=recording.time_s[:n],
        trajectory=recording.trajectory[:n],
        q_cmd=recording.q_cmd[:n],
        markers_px={name: pixels[:n] for name, pixels in recording.markers_px.items()},
        payload_kg=None,
        held_out=(),
    )
