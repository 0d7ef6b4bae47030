# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A diagnosis in sentences."""

from collections.abc import Sequence
import math
import re

from booster_ros.diagnosis.result import (
    AS_GOOD_AS_MEASURED, ChannelError, Diagnosis, FalseAdd, UnknownTerm)
from booster_ros.model.catalogue import EFFECTS
from booster_ros.report.engineering import Scale, number, scale_of, side_by_side

SCALING = (
    'Scaling effective area, dead volume, opening gain and largest area of the booster (A, V0, k, '
    'S_max) by one factor leaves every pressure and position unchanged: only their ratios are '
    'identified, not each of them.'
)

_CHANNELS = {
    'control_current': 'control current',
    'back_pressure': 'back pressure',
    'supply_pressure': 'supply pressure',
    'mass_flow': 'mass flow',
    'chamber_pressure': 'chamber pressure',
    'valve_position': 'valve position',
    'stem_velocity': 'stem velocity',
    'booster_force': 'booster force',
    'control_current_change': 'recent change of the control current',
    'chamber_pressure_change': 'recent change of the chamber pressure',
    'valve_position_change': 'recent change of the valve position',
    'booster_force_play': 'place of the booster force in a play',
    'time': 'time',
}

_PLACES = {
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
}


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


def verdict_title(diagnosis: Diagnosis) -> str:
    """Return the verdict as a headline."""
    if diagnosis.verdict == 'none':
        return 'The declared model is enough' if _reaches_noise(diagnosis) else 'Nothing to add'
    if diagnosis.verdict == 'unknown':
        place = place_label(_unknown_place(diagnosis))
        return f'The model lacks something in {place} that no named effect explains'
    return f'The model lacks {listing([effect_label(e.name) for e in diagnosis.effects])}'


def verdict_sentences(diagnosis: Diagnosis) -> list[str]:
    """Return what follows the headline: meaning, gain, what it may be instead, false adds."""
    sentences = _sentences(diagnosis)
    return [*sentences, _calibration(diagnosis.false_add)] if diagnosis.false_add else sentences


def _sentences(diagnosis: Diagnosis) -> list[str]:
    if diagnosis.verdict == 'none':
        return _sentences_on_none(diagnosis)
    if diagnosis.verdict == 'unknown':
        sentences = [_sentence_on_unknown(diagnosis.unknown)] if diagnosis.unknown else []
        return [*sentences, _gain(diagnosis), *_rest(diagnosis), *unknown_rivals(diagnosis)]
    sentences = []
    for effect in diagnosis.effects:
        meaning = EFFECTS[effect.name].meaning
        sentences.append(
            f'{capital(meaning)}. Its place is {place_label(effect.location)}.')
    sentences += [_gain(diagnosis), *_rest(diagnosis)]
    for effect in diagnosis.effects:
        if effect.confused_with:
            rivals = listing([effect_label(name) for name in effect.confused_with], 'or')
            sentences.append(
                f'This record cannot tell {effect_label(effect.name)} from {rivals}.')
    return sentences


def _sentences_on_none(diagnosis: Diagnosis) -> list[str]:
    errors = judged(diagnosis)
    refitted = listing([
        f'{channel_label(name)} by {error_scale(e).text(e.before)} (noise '
        f'{error_scale(e).text(e.noise)})' for name, e in errors.items()])
    first = f'Refitted within its tolerances it misses {refitted}, {_where(diagnosis)}.'
    if _reaches_noise(diagnosis):
        return [first, 'No effect of the catalogue improves on that beyond chance.']
    return [
        first, 'That is more than noise, but no effect of the catalogue, and no smooth term, '
        'improves on it beyond chance: a record with more movement may show what is missing.']


def _sentence_on_unknown(unknown: UnknownTerm) -> str:
    variable, size = scale_of(unknown.variable_unit), scale_of(unknown.unit)
    if unknown.reach is not None:
        width = size.text(2.0 * unknown.reach)
        inner = unknown.values[1:-1]
        rubs = size.text(0.5 * float(inner.max() - inner.min()))
        return (
            f'What the booster opens seems to follow its force through a play {width} wide, as '
            f'where {rubs} of friction hold its diaphragms. It is in the model as a table over '
            'the place in that play.')
    largest = max((float(v) for v in unknown.values), key=abs)
    over_time = unknown.variable == 'time'
    elsewhere = ', and the model is the declared one, refitted' if over_time else ''
    return (
        f'It depends on the {channel_label(unknown.variable)}, was seen from '
        f'{variable.text(unknown.seen[0])} to {variable.text(unknown.seen[1])} '
        f'and reaches {size.text(largest)}{_memory(unknown)}. It is in the model as a table that '
        f'fades to zero outside that range{elsewhere}.'
    )


def _memory(unknown: UnknownTerm) -> str:
    if unknown.memory is None:
        return ''
    return f'; what was is forgotten over {number(unknown.memory)} s'


def unknown_rivals(diagnosis: Diagnosis) -> list[str]:
    """Return a sentence on the terms that do as well as the one without a name, if any do."""
    return [f'A term in {listing([effect_label(one) for one in effect.confused_with], "or")} '
            'explains this record as well.'
            for effect in diagnosis.effects if effect.confused_with]


def unknown_experiment(unknown: UnknownTerm) -> str:
    """Return what would show the cause of a term without a name."""
    if unknown.variable == 'time':
        return ('record the same currents again, at another hour: what stays with the clock comes '
                'from outside, what stays with the currents from the valve')
    there = f'with the channels on both sides of {place_label(unknown.location)} recorded'
    if unknown.memory is not None:
        return (f'make one step and let it stand ten times {number(unknown.memory)} s, {there}: '
                'what creeps goes on where all else has settled')
    if unknown.reach is not None:
        return (f'let the control current rise and fall slowly over the same span, {there}: the '
                'chamber pressure over the back pressure is a loop')
    return f'vary the {channel_label(unknown.variable)} alone, {there}'


def _gain(diagnosis: Diagnosis) -> str:
    parts = [
        f'{channel_label(name)} from {error_scale(e).text(e.before)} to '
        f'{error_scale(e).text(e.after)} (noise {error_scale(e).text(e.noise)})'
        for name, e in judged(diagnosis).items()]
    falls = all(e.after < e.before for e in judged(diagnosis).values())
    verb = 'falls' if falls else 'goes'
    return f'With it the error {verb} in {listing(parts)}, {_where(diagnosis)}.'


def _rest(diagnosis: Diagnosis) -> list[str]:
    """Return a sentence on the channels in which more than noise is left, if there are any."""
    left = [f'{number(e.after / e.noise, 2)} times the noise in {channel_label(name)}'
            for name, e in judged(diagnosis).items() if e.after > AS_GOOD_AS_MEASURED * e.noise]
    return [f'It leaves {listing(left)}: that is not explained.'] if left else []


def _calibration(found: FalseAdd) -> str:
    interval = f'95 % interval {number(100.0 * found.low, 2)} to {number(100.0 * found.high, 2)} %'
    text = (f'Tried on simulated records in which nothing is missing, with noise like that of this '
            f'record, the same analysis added something in {found.gained} of {found.runs} '
            f'({number(100.0 * found.rate, 2)} %, {interval})')
    added = [f'{effect_label(name)} ({count})' for name, count in found.names.items()]
    return f'{text}: {listing(added)}.' if added else f'{text}.'


def error_scale(error: ChannelError) -> Scale:
    """Return the unit in which a channel's errors and its noise are read side by side."""
    return side_by_side(error.unit, (error.declared, error.before, error.after, error.noise))


def judged(diagnosis: Diagnosis) -> dict[str, ChannelError]:
    """Return the errors that judge the models: on held-out data where any of it could be scored."""
    held_out = {
        name: error for name, error in diagnosis.held_out.items() if math.isfinite(error.after)}
    return held_out or diagnosis.error


def _where(diagnosis: Diagnosis) -> str:
    is_held_out = any(math.isfinite(error.after) for error in diagnosis.held_out.values())
    return 'on data that no step of this analysis had seen' if is_held_out else (
        'on the data it was fitted to')


def _reaches_noise(diagnosis: Diagnosis) -> bool:
    return all(e.after <= AS_GOOD_AS_MEASURED * e.noise for e in judged(diagnosis).values())


def _unknown_place(diagnosis: Diagnosis) -> str:
    if diagnosis.unknown is not None:
        return diagnosis.unknown.location
    return diagnosis.effects[0].location if diagnosis.effects else 'the model'
