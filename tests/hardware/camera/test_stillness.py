import numpy as np
import pytest

from armtwin.hardware.camera.stillness import NoiseModel, StillnessWatch, to_grey

FRAME_S = 0.04


def greys(scene, angles: list[float]) -> list[np.ndarray]:
    frames = []
    for angle in angles:
        scene.angle_rad = angle
        frames.append(to_grey(scene.picture()))
    return frames


def rests_at(watch: StillnessWatch, frames: list[np.ndarray]) -> int | None:
    return next((i for i, frame in enumerate(frames) if watch.feed(frame, i * FRAME_S)), None)


@pytest.fixture
def noise(scene) -> NoiseModel:
    return NoiseModel.of(greys(scene, [0.0] * 12))


def test_a_third_of_a_pixel_at_the_tip_is_told_from_noise(scene, noise: NoiseModel):
    still, moved = greys(scene, [0.0, 0.33 / 144])  # the bar is 144 px long

    assert noise.moved(still, moved)


def test_noise_alone_is_no_motion_in_hundreds_of_pictures(scene, noise: NoiseModel):
    still, *others = greys(scene, [0.0] * 300)

    assert not any(noise.moved(still, other) for other in others)


def shot(level: float, random: np.random.Generator) -> np.ndarray:
    """A grey wall whose noise grows with the light, as a sensor's does, with a darker bar to the left."""
    light = np.full((360, 640), level)
    light[:, :160] = 20.0
    return np.clip(np.round(light + random.normal(0.0, 1.0, light.shape) * np.sqrt(0.06 * light)), 0, 255).astype(
        np.uint8
    )


def test_a_dark_part_is_held_to_its_own_smaller_noise():
    random = np.random.default_rng(0)
    quiet = NoiseModel.of([shot(200.0, random) for _ in range(12)])
    changed = shot(200.0, random)
    changed[100:200, 40:100] += 2  # lost in the bright part's noise of 3.5 levels, plain in the dark one's 1.1

    assert quiet.moved(shot(200.0, random), changed)


def test_a_dark_part_that_turns_bright_takes_on_the_bright_parts_noise():
    """Where the dark arm was, the bright wall is after a move: its larger noise is no motion."""
    random = np.random.default_rng(0)
    quiet = NoiseModel.of([shot(200.0, random) for _ in range(12)])
    bright = [
        np.where(np.arange(640) < 160, np.roll(shot(200.0, random), 320, axis=1), shot(200.0, random)) for _ in "ab"
    ]

    assert not quiet.moved(bright[0], bright[1])


def test_a_still_arm_rests_after_the_time_asked_for(scene, noise: NoiseModel):
    watch = StillnessWatch(noise, 0.12, 0.0)

    assert rests_at(watch, greys(scene, [0.0] * 10)) == 3  # the fourth frame comes 0.12 s after the first


def test_a_swinging_arm_does_not_rest(scene, noise: NoiseModel):
    swing = [0.02 * np.sin(1.3 * i) for i in range(40)]

    assert rests_at(StillnessWatch(noise, 0.12, 0.0), greys(scene, swing)) is None


def test_a_decaying_swing_rests_when_it_is_within_the_noise(scene, noise: NoiseModel):
    swing = [0.05 * np.exp(-i / 5) * np.sin(1.3 * i) for i in range(60)]

    index = rests_at(StillnessWatch(noise, 0.12, 0.0), greys(scene, swing))

    assert index is not None
    assert 0.05 * np.exp(-(index - 3) / 5) * 144 < 0.5  # px at the tip


def test_a_slow_creep_is_no_rest_although_neighbours_look_alike(scene, noise: NoiseModel):
    watch = StillnessWatch(noise, 0.4, 0.0)
    creep = [0.2 / 144 * i for i in range(40)]  # 0.2 px a frame, 2 px in the time asked for

    assert rests_at(watch, greys(scene, creep)) is None


def test_rest_is_not_declared_before_the_commanded_motion_ends(scene, noise: NoiseModel):
    watch = StillnessWatch(noise, 0.12, earliest_s=0.5)

    index = rests_at(watch, greys(scene, [0.0] * 30))

    assert index is not None
    assert index * FRAME_S >= 0.5


def test_old_pictures_of_a_late_stream_are_no_rest(scene, noise: NoiseModel):
    """A second of the old pose still comes out of the stream after the command; then the motion, then the new pose."""
    late = [0.0] * 25 + list(np.linspace(0, 0.3, 6)) + [0.3] * 10
    frames = greys(scene, [0.0, *late])

    index = rests_at(StillnessWatch(noise, 0.12, 0.0, reference=frames[0], onset_by_s=2.0), frames[1:])

    assert index is not None
    assert index >= 30


def test_an_arm_that_does_not_move_at_all_rests_once_the_onset_is_overdue(scene, noise: NoiseModel):
    frames = greys(scene, [0.0] * 40)

    index = rests_at(StillnessWatch(noise, 0.12, 0.0, reference=frames[0], onset_by_s=1.0), frames)

    assert index == 25


def test_a_flicker_before_the_motion_arrives_is_not_taken_for_it(scene, noise: NoiseModel):
    flash = greys(scene, [0.0] * 5)
    flash[2] = np.clip(flash[2].astype(int) + 40, 0, 255).astype(np.uint8)
    frames = [*flash, *greys(scene, [0.0] * 20), *greys(scene, [0.3] * 10)]

    index = rests_at(StillnessWatch(noise, 0.12, 0.0, reference=frames[0], onset_by_s=5.0), frames[1:])

    assert index is not None
    assert index >= 25


def test_the_first_picture_of_the_motion_is_noted(scene, noise: NoiseModel):
    frames = greys(scene, [0.0] * 6 + [0.1, 0.2, 0.3] + [0.3] * 8)
    watch = StillnessWatch(noise, 0.12, 0.0, reference=frames[0], onset_by_s=5.0)

    rests_at(watch, frames[1:])

    assert watch.onset_at_s == pytest.approx(5 * FRAME_S)
