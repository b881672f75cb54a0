"""What follows from a class's secret: each student's token and his robot. Nothing of it is written down."""

from __future__ import annotations

import base64
import contextlib
import hashlib
import hmac
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np

from armtwin.models.arm import nominal_arm
from armtwin.models.errors import JobError
from armtwin.scenarios.classes.class_file import ClassFile, Robots
from armtwin.sim.sealed import STRENGTHS, Sealed, draw_world

# What the sub-pixel detector leaves of a good picture, px: strengths are in multiples of it.
_NOISE_PX = 0.06
_TOKEN_BYTES = 18
# A student has his token to try secrets against: 16 MB and 50 ms a try keep a secret of four words from being guessed.
_SCRYPT = {"n": 1 << 14, "r": 8, "p": 1, "maxmem": 1 << 26}
# All arms of a class stand upright: did only some, the declared gravity would say which cannot sag.
_GRAVITY_M_S2 = (0.0, -9.81)


def token(group: ClassFile, who: str) -> str:
    """Return the token of a student, or of the instructor (`who` empty), that nobody guesses."""
    return base64.urlsafe_b64encode(_derived(group.secret, "token", who)[:_TOKEN_BYTES]).decode()


def generator(group: ClassFile, *words: str) -> np.random.Generator:
    """Return the random numbers of a purpose: the same words give the same numbers, others tell nothing of them."""
    return np.random.default_rng(int.from_bytes(_derived(group.secret, "draw", *words)))


def draw_robot(group: ClassFile, robot: str, attempt: int) -> Sealed:
    """Return the world of a robot and the truth about it; raises `JobError` where no draw shows above the noise."""
    return _drawn(group.secret, group.robots, robot, attempt)


@lru_cache(maxsize=1000)
def _drawn(secret: str, settings: Robots, robot: str, attempt: int) -> Sealed:
    rng = np.random.default_rng(int.from_bytes(_derived(secret, "draw", robot, str(attempt))))
    nothing = bool(rng.random() < settings.none_share)
    effect = None if nothing else str(rng.choice(sorted(settings.effects)))
    levels = list(STRENGTHS)
    for strength in levels[levels.index(settings.strength) :: -1]:
        with contextlib.suppress(JobError):
            return draw_world(
                rng,
                effect,
                strength,
                arm=replace(nominal_arm(), gravity_m_s2=np.array(_GRAVITY_M_S2)),
                n_poses=settings.pictures,
                noise_px=_NOISE_PX,
                markers=nominal_arm().marker_names,
                missing=0.0,
            )
    raise JobError(f"{robot}: no draw in which {effect} shows above the noise; leave it out of robots.effects")


def hidden_in(sealed: Sealed) -> dict[str, Any] | None:
    """Return the effect that is hidden, with its place and parameters; None where nothing is."""
    effects = sealed.truth["effects"]
    return dict(effects[0]) if effects else None


def _derived(secret: str, *words: str) -> bytes:
    return hmac.new(_key(secret), "\0".join(words).encode(), hashlib.sha256).digest()


@lru_cache(maxsize=8)
def _key(secret: str) -> bytes:
    return hashlib.scrypt(secret.encode(), salt=b"armtwin.class/1", **_SCRYPT)
