# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A diagnosis in sentences."""

from collections.abc import Sequence

import numpy as np

from booster_ros.diagnosis.result import Change, Diagnosis, FalseAdd, FoundEffect
from booster_ros.model.catalogue import EFFECTS
from booster_ros.report.engineering import number
from booster_ros.report.errors import (
    judged, leaves_much, left_in, meets_all, nothing_unforeseen, reaches_noise, scored,
    sentence_on_misses, sentences_on_gain, sentences_on_left_open, sentences_on_other_record,
    sentences_on_rest, sentences_on_tolerances)
from booster_ros.report.names import (
    capital, channel_label, channel_listing, effect_label, listing, place_label)
from booster_ros.report.unknown_term import (
    sentence_on_unknown, sentences_on_refused, unknown_of, unknown_rivals)

SCALING = (
    'Scaling effective area, dead volume, opening gain and largest area of the booster (A, V0, k, '
    'S_max) by one factor, and with them all other areas of flow, volumes, forces of the stem and '
    'its stops, and the moving mass, leaves every pressure and position unchanged: where no flow '
    'was compared only their ratios are identified, not each of them.'
)

LOUD = 0.05
"""Noise of a channel, as a share of its range, that is worth a word where nothing was found."""


def with_what_was_added(diagnosis: Diagnosis) -> str:
    """Return the words for the model with what was added."""
    return 'with the unnamed term' if diagnosis.verdict == 'unknown' else 'with the effect'


def _when(change: Change) -> str:
    """Return the words for when the valve changed."""
    return f'{change.time:.9g} s'


def verdict_title(diagnosis: Diagnosis) -> str:
    """Return the verdict as a headline."""
    change = diagnosis.change
    if change is not None and diagnosis.verdict == 'none':
        return f'{"The valve" if change.cut else "Something"} changed at {_when(change)}'
    if diagnosis.verdict == 'none':
        if meets_all(diagnosis) and reaches_noise(scored(diagnosis.validation)):
            return 'The declared model, refitted, is enough for this record'
        if reaches_noise(scored(diagnosis.error)) and nothing_unforeseen(
                judged(diagnosis)) and nothing_unforeseen(scored(diagnosis.validation)):
            return 'Nothing to add, but this record leaves a part of the model open'
        return 'Nothing to add'
    if change is not None and change.silent and change.cut:
        return f'From {_when(change)} on the {channel_listing(change.silent)} stands still'
    if diagnosis.verdict == 'unknown':
        if diagnosis.refused is not None:
            return 'The model lacks something that no named effect explains'
        place = place_label(_unknown_place(diagnosis))
        return f'The model lacks something in {place} that no named effect explains'
    lacks = f'The model lacks {listing([effect_label(e.name) for e in diagnosis.effects])}'
    return f'{lacks}, and more than that' if leaves_much(judged(diagnosis)) else lacks


def verdict_sentences(diagnosis: Diagnosis) -> list[str]:
    """
    Return what follows the headline.

    That is the meaning, the gain and what speaks against it, what it may be instead, how the other
    record does, and the false adds.
    """
    sentences = [*_sentences(diagnosis), *sentences_on_other_record(diagnosis)]
    return [*sentences, _calibration(diagnosis.false_add)] if diagnosis.false_add else sentences


def _sentences(diagnosis: Diagnosis) -> list[str]:
    change = diagnosis.change
    if change is not None and change.silent and change.cut:
        return [*_sentences_on_change(diagnosis, change), _sentence_on_silent(change),
                sentence_on_misses(diagnosis)]
    return [*(_sentences_on_change(diagnosis, change) if change else ()),
            *_sentences_on_verdict(diagnosis)]


def _sentences_on_change(diagnosis: Diagnosis, change: Change) -> list[str]:
    said = [f'Up to {_when(change)} the declared model, refitted to that part, meets the record to '
            f'the noise; from there on it misses by {number(np.sqrt(change.missed), 2)} times the '
            'noise. Something in the valve changed then, or shows for the first time.']
    if change.silent and not change.cut:
        said.append(_sentence_on_silent(change))
    if change.cut:
        return [*said, f'All that follows is of the record from {_when(change)} on.']
    return [*said, 'What came after is too little to be told apart, or tells no more: what follows '
            'is of the whole record.']


def _sentence_on_silent(change: Change) -> str:
    return (f'The {channel_listing(change.silent)} has one value from then on, or none, while the '
            'model moves it: the sensor is dead or cut off, or the valve sticks fast. It is not '
            'compared there.')


def _sentences_on_verdict(diagnosis: Diagnosis) -> list[str]:
    if diagnosis.verdict == 'none':
        return _sentences_on_none(diagnosis)
    if diagnosis.verdict == 'unknown' and diagnosis.refused is not None:
        return [sentence_on_misses(diagnosis), *sentences_on_refused(diagnosis.refused, diagnosis)]
    if diagnosis.verdict == 'unknown':
        unknown = unknown_of(diagnosis)
        sentences = [sentence_on_unknown(unknown)] if unknown else []
        return [*sentences, *sentences_on_gain(diagnosis), *sentences_on_rest(diagnosis),
                *unknown_rivals(diagnosis)]
    sentences = []
    for effect in diagnosis.effects:
        meaning = EFFECTS[effect.name].meaning
        sentences.append(
            f'{capital(meaning)}. Its place is {place_label(effect.location)}.')
    sentences.append(_standing_sentence(diagnosis.effects))
    sentences += [*sentences_on_gain(diagnosis), *sentences_on_tolerances(diagnosis),
                  *sentences_on_rest(diagnosis)]
    for effect in diagnosis.effects:
        if effect.confused_with:
            rivals = listing([effect_label(name) for name in effect.confused_with], 'or')
            sentences.append(
                f'This record cannot tell {effect_label(effect.name)} from {rivals}.')
    return sentences


def _standing_sentence(effects: Sequence[FoundEffect]) -> str:
    """Return what share of the missing is explained, by what, and how sure that is."""
    missed = ' of what the declared model misses'
    if len(effects) == 1:
        return f'Explained: {share_text(effects[0].explained)}{missed} ({effects[0].standing}).'
    # what two effects explain only together counts for each
    shares = [f'{share_text(effect.explained)}{"" if number else missed} only with '
              f'{effect_label(effect.name)} ({effect.standing})'
              for number, effect in enumerate(effects)]
    return f'Explained: {listing(shares)}.'


def share_text(share: float) -> str:
    """Return a share as a percentage; neither 0 nor all is said of what is not quite that."""
    percent = 100.0 * share
    if percent > 99.9:
        return 'more than 99.9 %'
    return 'less than 0.1 %' if percent < 0.1 else f'{percent:.3g} %'


def _sentences_on_none(diagnosis: Diagnosis) -> list[str]:
    first = sentence_on_misses(diagnosis)
    if meets_all(diagnosis):
        return [first, 'No effect of the catalogue improves on that beyond chance.',
                *_hidden_in_noise(diagnosis)]
    if reaches_noise(judged(diagnosis)):
        left = listing(left_in(scored(diagnosis.error)))
        return [first, f'Of the data that were fitted it leaves {left}, but no effect of the '
                'catalogue, and no smooth term, improves on that beyond chance: a record with more '
                'movement may show what is missing.']
    open_yet = sentences_on_left_open(diagnosis)
    if reaches_noise(scored(diagnosis.error)) and nothing_unforeseen(judged(diagnosis)):
        return [first, 'The data that were fitted are met to the noise.', *open_yet]
    if reaches_noise(scored(diagnosis.error)):
        return [
            first, 'That is more than noise, but the data that were fitted are met to the noise: '
            'what is missing shows in the unseen ones alone, which nothing may be fitted to. '
            'Something changed on the way, or they go where the others did not.', *open_yet]
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


def _calibration(found: FalseAdd) -> str:
    interval = f'95 % interval {number(100.0 * found.low, 2)} to {number(100.0 * found.high, 2)} %'
    text = (f'Tried on simulated records in which nothing is missing, with noise like that of this '
            f'record, the same analysis added something in {found.gained} of {found.runs} '
            f'({number(100.0 * found.rate, 2)} %, {interval})')
    added = [f'{effect_label(name)} ({count})' for name, count in found.names.items()]
    return f'{text}: {listing(added)}.' if added else f'{text}.'


def _unknown_place(diagnosis: Diagnosis) -> str:
    unknown = unknown_of(diagnosis)
    if unknown is not None:
        return unknown.location
    return diagnosis.effects[0].location if diagnosis.effects else 'the model'
