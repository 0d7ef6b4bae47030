# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Test signals: seeded control currents in A, one value per sample, that move the valve.

Every signal begins with the current the valve has settled at before the record.
"""

from collections.abc import Callable

import numpy as np

from .plant import SAMPLE_TIME

LOWEST, HIGHEST = 0.356e-3, 0.4745e-3  # A, limits of every signal
LEVELS = (0.364e-3, 0.465e-3)  # A, between which steps choose


def _samples(seconds: float) -> int:
    return round(seconds / SAMPLE_TIME)


def _next_level(generator: np.random.Generator, level: float) -> float:
    """Choose a level at least 3 µA away."""
    while True:
        chosen = generator.uniform(*LEVELS)
        if abs(chosen - level) > 3e-6:
            return chosen


def stairs(generator: np.random.Generator, seconds: float) -> np.ndarray:
    """Return steps to random levels, each held for 4 to 11 s."""
    pieces: list[np.ndarray] = []
    level = generator.uniform(*LEVELS)
    while sum(piece.size for piece in pieces) < _samples(seconds):
        pieces.append(np.full(_samples(generator.uniform(4.0, 11.0)), level))
        level = _next_level(generator, level)
    return np.concatenate(pieces)[: _samples(seconds)]


def ramps(generator: np.random.Generator, seconds: float) -> np.ndarray:
    """Return ramps of 4 to 15 s between random levels, each held for 2 to 6 s."""
    level = generator.uniform(*LEVELS)
    pieces: list[np.ndarray] = []
    while sum(piece.size for piece in pieces) < _samples(seconds):
        pieces.append(np.full(_samples(generator.uniform(2.0, 6.0)), level))
        level, previous = _next_level(generator, level), level
        pieces.append(np.linspace(previous, level, _samples(generator.uniform(4.0, 15.0))))
    return np.concatenate(pieces)[: _samples(seconds)]


def triangle(seconds: float) -> np.ndarray:
    """Return one slow triangle over the whole travel."""
    half = _samples(0.5 * seconds)
    rising = np.linspace(LOWEST, LEVELS[1], half, endpoint=False)
    falling = np.linspace(LEVELS[1], LOWEST, _samples(seconds) - half, endpoint=False)
    return np.concatenate([rising, falling])


def sines(generator: np.random.Generator, seconds: float) -> np.ndarray:
    """Return four sines with periods of 3 to 30 s about a random middle."""
    time = np.arange(_samples(seconds)) * SAMPLE_TIME
    periods = np.exp(generator.uniform(np.log(3.0), np.log(30.0), 4))
    amplitudes = generator.uniform(6e-6, 22e-6, 4)
    phases = generator.uniform(0.0, 2.0 * np.pi, 4)
    current = generator.uniform(0.41e-3, 0.43e-3) + sum(
        amplitude * np.sin(2.0 * np.pi * time / period + phase)
        for amplitude, period, phase in zip(amplitudes, periods, phases, strict=True)
    )
    return np.clip(current, LOWEST, HIGHEST)


def prbs(generator: np.random.Generator, seconds: float) -> np.ndarray:
    """Return random switching every 1.5 s between two levels, which move every 30 s."""
    clock = _samples(1.5)
    pieces: list[np.ndarray] = []
    while sum(piece.size for piece in pieces) < _samples(seconds):
        middle = generator.uniform(0.395e-3, 0.445e-3)
        swing = generator.uniform(8e-6, 22e-6)
        signs = generator.choice([-1.0, 1.0], 20)
        pieces.append(np.repeat(middle + swing * signs, clock))
    return np.clip(np.concatenate(pieces)[: _samples(seconds)], LOWEST, HIGHEST)


def mixed(generator: np.random.Generator, seconds: float) -> np.ndarray:
    """Return steps (45 %), one triangle (35 %), sines (20 %)."""
    return np.concatenate(
        [
            stairs(generator, 0.45 * seconds),
            triangle(0.35 * seconds),
            sines(generator, 0.2 * seconds),
        ]
    )


KINDS: dict[str, Callable[[np.random.Generator, float], np.ndarray]] = {
    'mixed': mixed,
    'stairs': stairs,
    'ramps': ramps,
    'sines': sines,
    'prbs': prbs,
}
