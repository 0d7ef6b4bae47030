# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The positioner's electronics: three firmwares, each sampling every 10 ms."""

from typing import NamedTuple

from numba import njit

from .converter import play

NONE, PROPORTIONAL, INTEGRATING, PIEZO = range(4)
KINDS = ('none', 'proportional', 'integrating', 'piezo')


class Positioner(NamedTuple):
    """Constants in SI units; everything below the blank line is neutral at its default."""

    kind: int = NONE
    gain: float = 0.17  # A/m
    reset_time: float = 4.2  # s
    rate_time: float = 0.0  # s
    middle: float = 0.4325e-3  # A, sent without an error
    highest: float = 0.74e-3  # A
    dead_zone: float = 0.0  # m
    sample_time: float = 0.01  # s
    slew: float = 1e-3  # A/s, of a piezo valve that is open
    shortest: float = 2e-3  # s, of its pulses

    slack: float = 0.0  # m, full width of lost motion in the feedback lever
    widened: float = 0.0  # m, of the dead zone, to either side
    rise_time: float = 0.0  # s for the whole travel, opening; 0: at once
    fall_time: float = 0.0  # s
    detuned: float = 0.0  # relative change of the gain


class Electronics(NamedTuple):
    """What it remembers: reset action (A), set point after the ramp, lever and last reading (m)."""

    reset: float
    ramped: float
    lever: float
    reading: float


@njit(cache=True)
def begun(positioner, set_point, position):
    """Return the electronics that has long seen this set point and position, m."""
    return Electronics(0.0, set_point, position, position)


@njit(cache=True)
def decide(positioner, memory, level, set_point, position, travel):
    """
    Take a sample: return what is remembered, the current and how it ramps, A/s for s.

    `level` is the current that flows, A.
    """
    lever = play(memory.lever, position, positioner.slack)
    ramped = set_point
    if positioner.rise_time > 0.0:
        ramped = min(ramped, memory.ramped + positioner.sample_time * travel / positioner.rise_time)
    if positioner.fall_time > 0.0:
        ramped = max(ramped, memory.ramped - positioner.sample_time * travel / positioner.fall_time)
    gain = positioner.gain * (1.0 + positioner.detuned)
    zone = positioner.dead_zone + positioner.widened
    deviation = ramped - lever
    if abs(deviation) <= zone:
        deviation = 0.0
    elif deviation > 0.0:
        deviation -= zone
    else:
        deviation += zone
    speed = (lever - memory.reading) / positioner.sample_time
    wanted = gain * (deviation - positioner.rate_time * speed)
    reset, slope, lasts = memory.reset, 0.0, 0.0
    if positioner.kind == PIEZO:
        if deviation != 0.0:
            lasts = min(abs(wanted) / positioner.slew, positioner.sample_time)
            if lasts < positioner.shortest:
                lasts = 0.0
            slope = positioner.slew if wanted > 0.0 else -positioner.slew
    else:
        wanted += positioner.middle
        if positioner.kind == INTEGRATING:
            grown = reset + gain * deviation * positioner.sample_time / positioner.reset_time
            winds_up = deviation > 0.0 and wanted + grown > positioner.highest
            winds_down = deviation < 0.0 and wanted + grown < 0.0
            if not winds_up and not winds_down:
                reset = grown
            wanted += reset
        level = min(max(wanted, 0.0), positioner.highest)
    return Electronics(reset, ramped, lever, lever), level, slope, lasts
