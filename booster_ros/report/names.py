# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The words for channels, places and effects."""

from collections.abc import Iterable, Sequence
import re

_CHANNELS = {
    'control_current': 'control current',
    'back_pressure': 'back pressure',
    'supply_pressure': 'supply pressure',
    'mass_flow': 'mass flow',
    'chamber_pressure': 'chamber pressure',
    'valve_position': 'valve position',
    'pressure_drop': 'pressure drop over the process valve',
    'stem_velocity': 'stem velocity',
    'booster_force': 'booster force',
    'back_pressure_error': 'way that the back pressure still has to go',
    'control_current_change': 'recent change of the control current',
    'chamber_pressure_change': 'recent change of the chamber pressure',
    'valve_position_change': 'recent change of the valve position',
    'booster_force_play': 'place of the booster force in a play',
    'time': 'time',
}

_PLACES = {
    'position_controller': 'the position controller',
    'ep_converter': 'the E/P converter',
    'booster': 'the booster',
    'supply': 'the supply',
    'tubing': 'the tubing',
    'chamber': 'the actuator chamber',
    'stem': 'the stem',
    'sensor': 'a sensor',
    'pressure_sensor': 'the pressure sensor',
    'position_sensor': 'the position sensor',
    'chamber_volume': 'the volume of the actuator chamber',
    'ep_converter_lag': 'the lag of the E/P converter',
}

_POSITIVE = {
    'ep_converter': 'towards more back pressure',
    'booster': 'towards filling the chamber',
    'supply': 'towards more supply pressure',
    'chamber': 'out of the chamber',
    'stem': 'towards open',
    'pressure_sensor': 'added to the reading',
    'position_sensor': 'added to the reading',
    'chamber_volume': 'more volume',
    'ep_converter_lag': 'slower, 1 being 2.7 times as slow',
}


def positive_is(location: str) -> str:
    """Return what a positive value of a term without a name does in its place."""
    return _POSITIVE[location]


def channel_label(name: str) -> str:
    """Return the words for a channel or variable."""
    return _CHANNELS.get(name, name.replace('_', ' '))


def place_label(location: str) -> str:
    """Return the words for a location."""
    return _PLACES.get(location, location.replace('_', ' '))


def effect_label(name: str) -> str:
    """Return the words for an effect, or for a term without a name."""
    words = re.sub(' over (.*) change$', r' over a recent change of \1', name.replace('_', ' '))
    return re.sub('^ep ', 'E/P ', words)


def capital(text: str) -> str:
    """Return a text with its first letter, and only that, made a capital."""
    return text[:1].upper() + text[1:]


def listing(words: Sequence[str], last: str = 'and') -> str:
    """Return 'a, b and c'."""
    if len(words) < 2:
        return ''.join(words)
    return f'{", ".join(words[:-1])} {last} {words[-1]}'


def channel_listing(names: Iterable[str]) -> str:
    """Return 'chamber pressure and valve position' for the names of channels."""
    return listing([channel_label(name) for name in names])
