# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Sentences on how much the models miss a record by."""

from collections.abc import Mapping
import math

import numpy as np

from booster_ros.diagnosis.data.blocks import rows_of
from booster_ros.diagnosis.result import AS_GOOD_AS_MEASURED, ChannelError, Diagnosis
from booster_ros.report.engineering import Scale, common_scale, digits_apart, number
from booster_ros.report.names import channel_label, channel_listing, listing

WORSE = 1.05
"""Ratio of two errors beyond which one counts as larger: beyond it, say, data that were not fitted
speak against what was added."""

CONFIRMED = 0.9
"""Ratio of the error after to the error before, where something is missing, below which what was
added has a share in that."""

FAR_OFF = 3.0
"""Tolerances beyond which a declared parameter is far from what it was expected to be."""

MUCH = 3.0
"""Multiple of the noise from which what is left belongs in the headline."""

FEW = 25
"""Values of a channel in the test set below which the report says how few there are."""


def error_scale(error: ChannelError) -> Scale:
    """Return the unit in which a channel's errors and its noise are read side by side."""
    return common_scale(error.unit, (error.declared, error.before, error.after, error.noise))


def scored(errors: Mapping[str, ChannelError]) -> dict[str, ChannelError]:
    """Return the errors of the channels that could be compared."""
    return {name: error for name, error in errors.items() if math.isfinite(error.after)}


def judged(diagnosis: Diagnosis) -> dict[str, ChannelError]:
    """Return the errors that judge the models: on held-out data where any of it could be scored."""
    return scored(diagnosis.held_out) or diagnosis.error


def reaches_noise(errors: Mapping[str, ChannelError]) -> bool:
    """Tell whether the last model leaves no more than noise in any channel."""
    return all(error.met for error in errors.values())


def nothing_unforeseen(errors: Mapping[str, ChannelError]) -> bool:
    """Tell whether the last model leaves no more than noise and what the record leaves open."""
    return all(error.foreseen for error in errors.values())


def leaves_much(errors: Mapping[str, ChannelError]) -> bool:
    """Tell whether far more than noise is left of what the record does not leave open."""
    return any((error.unforeseen if math.isfinite(error.unforeseen) else error.after)
               > MUCH * error.noise for error in errors.values())


def meets_all(diagnosis: Diagnosis) -> bool:
    """Tell whether the last model leaves no more than noise, held out or fitted."""
    return reaches_noise(judged(diagnosis)) and reaches_noise(scored(diagnosis.error))


def unseen(diagnosis: Diagnosis) -> str:
    """Return the words for the test set, which has been seen where it decided the verdict."""
    return 'that nothing was fitted to, but that had a say in the verdict' if diagnosis.decided \
        else 'that no step of this analysis had seen'


def left_in(errors: Mapping[str, ChannelError], compared: bool = False) -> list[str]:
    """Return phrases on how much is left in each channel that leaves more than noise."""
    return [_in_noises(name, e, e.after)
            + (f' ({number(e.before / e.noise, 2)} without it)' if compared else '')
            for name, e in errors.items() if not e.met]


def _in_noises(name: str, error: ChannelError, value: float) -> str:
    return f'{number(value / error.noise, 2)} times the noise in {channel_label(name)}'


def sentence_on_misses(diagnosis: Diagnosis) -> str:
    """Return by how much the refitted model with nothing added misses."""
    refitted = listing([
        f'{channel_label(name)} by {error_scale(e).text(e.before)} (noise '
        f'{error_scale(e).text(e.noise)})' for name, e in judged(diagnosis).items()])
    return f'Refitted within its tolerances it misses {refitted}, {_where(diagnosis)}.'


def sentences_on_gain(diagnosis: Diagnosis) -> list[str]:
    """Return what the error comes to with what was added, and what speaks against the addition."""
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
        gain = (f'Data {unseen(diagnosis)} need nothing added, and so do not confirm it: there '
                f'the error goes in {changes}.')
    return [gain, *_doubts(errors)]


def sentences_on_tolerances(diagnosis: Diagnosis) -> list[str]:
    """Return which parameters would be far off if nothing is missing, where that may be so."""
    everywhere = (*judged(diagnosis).values(), *scored(diagnosis.error).values())
    if any(error.before > WORSE * max(error.after, error.noise) for error in everywhere):
        return []
    off = [f'{one.name} at {scale.text(one.before, digits)} instead of '
           f'{scale.text(one.given, digits)} ({number(abs(one.away_before), 2)} times its '
           'tolerance)'
           for one in diagnosis.refitted if abs(one.away_before) > FAR_OFF
           for scale in [common_scale(one.unit, (one.before, one.given))]
           for digits in [digits_apart(one.before, one.given)]]
    if not off:
        return []
    return [f'The declared model alone leaves no more than noise in this record, with '
            f'{listing(off)}: if that can be, nothing is missing.']


def sentences_on_rest(diagnosis: Diagnosis) -> list[str]:
    """Return what is left beyond noise: what is not explained, and what the record leaves open."""
    errors = judged(diagnosis)
    left = left_in({name: error for name, error in errors.items() if not error.foreseen})
    return [*([f'It leaves {listing(left)}: that is not explained.'] if left else ()),
            *sentences_on_left_open(diagnosis)]


def sentences_on_left_open(diagnosis: Diagnosis) -> list[str]:
    """Return how much of the error in the test set is due to what this record leaves open."""
    return _of_what_is_open(judged(diagnosis), 'the fitted part of this record')


def _of_what_is_open(errors: Mapping[str, ChannelError], told_by: str) -> list[str]:
    missed = {name: error for name, error in errors.items() if not error.met}
    all_of_it = {name: error for name, error in missed.items() if error.foreseen}
    a_part = {name: error for name, error in missed.items()
              if not error.foreseen and error.left_open > error.noise}
    said = []
    if all_of_it:
        said.append(f'What is left in {channel_listing(all_of_it)} need be no sign of anything '
                    f'missing: {_models_apart(all_of_it, told_by)}.')
    if a_part:
        said.append(f'Of what is left in {channel_listing(a_part)} a part may come of parameters '
                    f'that are hardly told: {_models_apart(a_part, told_by)}.')
    return said


def _models_apart(errors: Mapping[str, ChannelError], told_by: str) -> str:
    apart = listing([_in_noises(name, e, e.left_open) for name, e in errors.items()])
    return f'models that meet {told_by} as well differ from this one there by {apart}'


def sentences_on_other_record(diagnosis: Diagnosis) -> list[str]:
    """Return how the model does on the record that only judges, if there is one."""
    errors = scored(diagnosis.validation)
    if not errors:
        return []
    added = diagnosis.added
    model = 'With it the model' if added else 'The refitted model'
    left = listing(left_in(errors, compared=added))
    if left:
        hidden = not (added or nothing_unforeseen(errors)) and meets_all(diagnosis)
        what = ': something is missing there that this record does not show' if hidden else ''
        said = f'{model} misses the other record by {left}{what}.'
    else:
        needless = ', which needs nothing added' if added and not _missing(errors) else ''
        said = f'{model} meets {channel_listing(errors)} of the other record{needless}.'
    doubts = _doubts(errors) if added else []
    return [said, *(doubts or _of_what_is_open(errors, 'the first record'))]


def _doubts(errors: Mapping[str, ChannelError]) -> list[str]:
    """Return a sentence where data that were not fitted speak against what was added, if any do."""
    rising = [name for name, error in errors.items()
              if error.after > WORSE * max(error.before, error.noise)]
    if rising:
        return [f'There the error rises with it in {channel_listing(rising)}: trust it less.']
    missing = _missing(errors)
    if missing and all(error.after >= CONFIRMED * error.before for error in missing):
        return ['There as much is missing with it as without: that does not confirm it.']
    return []


def _missing(errors: Mapping[str, ChannelError]) -> list[ChannelError]:
    """Return the errors beyond noise that the model has with nothing added."""
    return [error for error in errors.values()
            if error.before > AS_GOOD_AS_MEASURED * error.noise]


def _where(diagnosis: Diagnosis) -> str:
    if not scored(diagnosis.held_out):
        return 'on the data it was fitted to'
    return f'on data {unseen(diagnosis)}{_how_few(diagnosis)}'


def _how_few(diagnosis: Diagnosis) -> str:
    """Return how few values the test set has, if they are few; in a sweep each row is much."""
    experiment = diagnosis.experiment
    locked = rows_of(list(diagnosis.segments), 'test', len(experiment.time))
    values = max(int(np.isfinite(measured[locked]).sum())
                 for measured in experiment.measured.values())
    if experiment.quasi_static or values >= FEW:
        return ''
    return f', of which there are {values} in a channel at the most'
