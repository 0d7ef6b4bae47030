# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A diagnosis in sentences."""

from collections.abc import Iterable, Mapping, Sequence
import math
import re

import numpy as np

from booster_ros.diagnosis.experiment.segments import rows_of
from booster_ros.diagnosis.result import (
    AS_GOOD_AS_MEASURED, WORTH_SAYING, Change, ChannelError, Diagnosis, FalseAdd, Refused,
    UnknownTerm)
from booster_ros.model.catalogue import EFFECTS
from booster_ros.report.engineering import Scale, number, scale_of, side_by_side

SCALING = (
    'Scaling effective area, dead volume, opening gain and largest area of the booster (A, V0, k, '
    'S_max) by one factor, and with them all other areas of flow, volumes, forces of the stem and '
    'its stops, and the moving mass, leaves every pressure and position unchanged: where no flow '
    'was compared only their ratios are identified, not each of them.'
)

LOUD = 0.05
"""Share of its range from which the noise of a channel is worth a word where nothing was found."""

WORSE = 1.05
"""Error after, relative to before, from which data not fitted speak against what was added."""

CONFIRMED = 0.9
"""Where something is missing, error after, relative to before, up to which what was added has a
share in that."""

FEW = 25
"""Values of a channel in the locked part below which their number is said."""

SEVERAL = 4.0
"""Mean square left, in that of the noise, from which one changed parameter alone is not all."""

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

_UNSEEN = 'that no step of this analysis had seen'

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


def with_what_was_added(diagnosis: Diagnosis) -> str:
    """Return the words for the model with what was added."""
    return 'with the unnamed term' if diagnosis.verdict == 'unknown' else 'with the effect'


def _when(change: Change) -> str:
    """Return the words for when the valve changed."""
    return f'{change.time:.5g} s'


def verdict_title(diagnosis: Diagnosis) -> str:
    """Return the verdict as a headline."""
    if diagnosis.change is not None and diagnosis.verdict == 'none':
        return f'Something changed at {_when(diagnosis.change)}'
    if diagnosis.verdict == 'none':
        if _reaches_noise(judged(diagnosis)) and _reaches_noise(scored(diagnosis.validation)):
            return 'The declared model, refitted, is enough for this record'
        return 'Nothing to add'
    if diagnosis.change is not None and diagnosis.change.moved:
        return f'The valve changed at {_when(diagnosis.change)}'
    if diagnosis.verdict == 'unknown':
        if diagnosis.refused is not None:
            return 'The model lacks something that no named effect explains'
        place = place_label(_unknown_place(diagnosis))
        return f'The model lacks something in {place} that no named effect explains'
    return f'The model lacks {listing([effect_label(e.name) for e in diagnosis.effects])}'


def verdict_sentences(diagnosis: Diagnosis) -> list[str]:
    """
    Return what follows the headline.

    Meaning, gain and what speaks against it, what it may be instead, the other record, false adds.
    """
    sentences = [*_sentences(diagnosis), *_on_the_other(diagnosis)]
    return [*sentences, _calibration(diagnosis.false_add)] if diagnosis.false_add else sentences


def _sentences(diagnosis: Diagnosis) -> list[str]:
    change = diagnosis.change
    if change is not None and change.moved:
        return [*_sentences_on_change(diagnosis, change), _missed(diagnosis),
                _sentence_on_moved(change)]
    return [*(_sentences_on_change(diagnosis, change) if change else ()),
            *_sentences_on_verdict(diagnosis)]


def _sentences_on_change(diagnosis: Diagnosis, change: Change) -> list[str]:
    said = [f'Up to {_when(change)} the declared model, refitted to that part, meets the record to '
            f'the noise; from there on it misses by {number(np.sqrt(change.missed), 2)} times the '
            'noise. Something in the valve changed then, or shows for the first time.']
    if change.cut:
        return [*said, f'All that follows is of the record from {_when(change)} on.']
    return [*said, 'What came after is too little to be told apart, or tells no more: what follows '
            'is of the whole record.']


def _sentence_on_moved(change: Change) -> str:
    moves = listing([f'{one.name} from {scale.text(one.before)} to {scale.text(one.after)} '
                     f'({number(np.sqrt(one.left), 2)} times the noise left)'
                     for one in change.moved
                     for scale in [side_by_side(one.unit, (one.before, one.after))]], 'or')
    several = '; more than one has changed' if change.moved[0].left > SEVERAL else ''
    return ('The declared model is enough for both parts, with other parameters. Changed alone, '
            f'all others as they were before, comes nearest: {moves}{several}.')


def _sentences_on_verdict(diagnosis: Diagnosis) -> list[str]:
    if diagnosis.verdict == 'none':
        return _sentences_on_none(diagnosis)
    if diagnosis.verdict == 'unknown' and diagnosis.refused is not None:
        return [_missed(diagnosis), *_sentences_on_refused(diagnosis.refused, diagnosis.held_out)]
    if diagnosis.verdict == 'unknown':
        sentences = [_sentence_on_unknown(diagnosis.unknown)] if diagnosis.unknown else []
        return [*sentences, *_gain(diagnosis), *_rest(diagnosis), *unknown_rivals(diagnosis)]
    sentences = []
    for effect in diagnosis.effects:
        meaning = EFFECTS[effect.name].meaning
        sentences.append(
            f'{capital(meaning)}. Its place is {place_label(effect.location)}.')
    sentences += [*_gain(diagnosis), *_rest(diagnosis)]
    for effect in diagnosis.effects:
        if effect.confused_with:
            rivals = listing([effect_label(name) for name in effect.confused_with], 'or')
            sentences.append(
                f'This record cannot tell {effect_label(effect.name)} from {rivals}.')
    return sentences


def _missed(diagnosis: Diagnosis) -> str:
    refitted = listing([
        f'{channel_label(name)} by {error_scale(e).text(e.before)} (noise '
        f'{error_scale(e).text(e.noise)})' for name, e in judged(diagnosis).items()])
    return f'Refitted within its tolerances it misses {refitted}, {_where(diagnosis)}.'


def _sentences_on_refused(refused: Refused, errors: Mapping[str, ChannelError]) -> list[str]:
    changes = []
    for name, error in refused.error.items():
        before = errors[name].before
        scale = side_by_side(errors[name].unit, (before, error))
        changes.append(f'{channel_label(name)} from {scale.text(before)} to {scale.text(error)}')
    beyond = '' if refused.beyond < WORTH_SAYING else (
        f'{100.0 * refused.beyond:.0f} % of these data go beyond the range in which it was seen, '
        'where it says nothing. ')
    return [
        f'A smooth term in {place_label(refused.location)} over the '
        f'{channel_label(refused.variable)} explains part of what it was fitted to, but data '
        f'{_UNSEEN} speak against it: there the error goes with it in {listing(changes)}. '
        f'{beyond}It is not in the model.',
        f'That {place_label(refused.location)} is the place is a guess.']


def _sentences_on_none(diagnosis: Diagnosis) -> list[str]:
    first = _missed(diagnosis)
    if _reaches_noise(judged(diagnosis)):
        return [first, 'No effect of the catalogue improves on that beyond chance.',
                *_hidden_in_noise(diagnosis)]
    if _reaches_noise(scored(diagnosis.error)):
        return [
            first, 'That is more than noise, but the data that were fitted are met to the noise: '
            'what is missing shows in the unseen ones alone, which nothing may be fitted to. '
            'Something changed on the way, or they go where the others did not.']
    return [
        first, 'That is more than noise, but no effect of the catalogue, and no smooth term, '
        'improves on the data it was fitted to beyond chance: a record with more movement may '
        'show what is missing.']


def _hidden_in_noise(diagnosis: Diagnosis) -> list[str]:
    """Return a sentence for each channel whose noise would hide much, where nothing was found."""
    shares = {name: error.noise / max(float(np.nanmax(values) - np.nanmin(values)), error.noise)
              for name, error in judged(diagnosis).items()
              if np.isfinite(values := diagnosis.experiment.measured[name]).any()}
    return [f'The noise of the {channel_label(name)} is {100.0 * share:.0f} % of its range in this '
            'record: what is smaller may be there all the same.'
            for name, share in shares.items() if share > LOUD]


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


def _gain(diagnosis: Diagnosis) -> list[str]:
    errors = judged(diagnosis)
    changes = listing([
        f'{channel_label(name)} from {error_scale(e).text(e.before)} to '
        f'{error_scale(e).text(e.after)} (noise {error_scale(e).text(e.noise)})'
        for name, e in errors.items()])
    falls = all(e.after < e.before for e in errors.values())
    gain = f'With it the error {"falls" if falls else "goes"} in {changes}, {_where(diagnosis)}.'
    if not scored(diagnosis.held_out):
        return [gain]
    if not _missing(errors):
        gain = (f'Data {_unseen(diagnosis)} need nothing added, and so do not confirm it: there '
                f'the error goes in {changes}.')
    return [gain, *_doubts(errors)]


def _missing(errors: Mapping[str, ChannelError]) -> list[ChannelError]:
    """Return the errors beyond noise that the model has with nothing added."""
    return [error for error in errors.values()
            if error.before > AS_GOOD_AS_MEASURED * error.noise]


def _doubts(errors: Mapping[str, ChannelError]) -> list[str]:
    """Return a sentence where data that were not fitted speak against what was added, if any do."""
    rising = [name for name, error in errors.items()
              if error.after > WORSE * max(error.before, error.noise)]
    if rising:
        return [f'There the error rises with it in {_channels(rising)}: trust it less.']
    missing = _missing(errors)
    if missing and all(error.after >= CONFIRMED * error.before for error in missing):
        return ['There as much is missing with it as without: that does not confirm it.']
    return []


def _rest(diagnosis: Diagnosis) -> list[str]:
    """Return a sentence on the channels in which more than noise is left, if there are any."""
    left = _left(judged(diagnosis))
    return [f'It leaves {listing(left)}: that is not explained.'] if left else []


def _left(errors: Mapping[str, ChannelError], compared: bool = False) -> list[str]:
    """Return how much is left in each channel in which that is more than noise."""
    return [f'{number(e.after / e.noise, 2)} times the noise in {channel_label(name)}'
            + (f' ({number(e.before / e.noise, 2)} without it)' if compared else '')
            for name, e in errors.items() if not _is_noise(e)]


def _on_the_other(diagnosis: Diagnosis) -> list[str]:
    """Return how the model does on the record that only judges, if there is one."""
    errors = scored(diagnosis.validation)
    if not errors:
        return []
    added = diagnosis.added
    model = 'With it the model' if added else 'The refitted model'
    left = listing(_left(errors, compared=added))
    if left:
        hidden = not added and _reaches_noise(judged(diagnosis))
        what = ': something is missing there that this record does not show' if hidden else ''
        said = f'{model} misses the other record by {left}{what}.'
    else:
        needless = ', which needs nothing added' if added and not _missing(errors) else ''
        said = f'{model} meets {_channels(errors)} of the other record{needless}.'
    return [said, *(_doubts(errors) if added else ())]


def _channels(names: Iterable[str]) -> str:
    return listing([channel_label(name) for name in names])


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


def scored(errors: Mapping[str, ChannelError]) -> dict[str, ChannelError]:
    """Return the errors of the channels that could be compared."""
    return {name: error for name, error in errors.items() if math.isfinite(error.after)}


def judged(diagnosis: Diagnosis) -> dict[str, ChannelError]:
    """Return the errors that judge the models: on held-out data where any of it could be scored."""
    return scored(diagnosis.held_out) or diagnosis.error


def _where(diagnosis: Diagnosis) -> str:
    if not scored(diagnosis.held_out):
        return 'on the data it was fitted to'
    return f'on data {_unseen(diagnosis)}{_how_few(diagnosis)}'


def _how_few(diagnosis: Diagnosis) -> str:
    """Return how little there is in the locked part, where it is; of a sweep each row is much."""
    experiment = diagnosis.experiment
    locked = rows_of(list(diagnosis.segments), ('test',), len(experiment.time))
    values = max(int(np.isfinite(measured[locked]).sum())
                 for measured in experiment.measured.values())
    if experiment.quasi_static or values >= FEW:
        return ''
    return f', of which there are {values} in a channel at the most'


def _unseen(diagnosis: Diagnosis) -> str:
    """Return what the locked part is: where it has decided, it has been seen."""
    return 'that nothing was fitted to, but that had a say in the verdict' if diagnosis.decided \
        else _UNSEEN


def _is_noise(error: ChannelError) -> bool:
    return error.after <= AS_GOOD_AS_MEASURED * error.noise


def _reaches_noise(errors: Mapping[str, ChannelError]) -> bool:
    return all(_is_noise(error) for error in errors.values())


def _unknown_place(diagnosis: Diagnosis) -> str:
    if diagnosis.unknown is not None:
        return diagnosis.unknown.location
    return diagnosis.effects[0].location if diagnosis.effects else 'the model'
