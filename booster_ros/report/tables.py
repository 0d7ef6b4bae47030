# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The tables of the report page."""

from collections.abc import Mapping
from html import escape
import math

from booster_ros.diagnosis.result import (
    FAR_OFF, ChannelError, Diagnosis, FoundEffect, Refitted, Suspect)
from booster_ros.model.parameters import DESCRIPTIONS
from booster_ros.report.engineering import (
    Scale, common_scale, digits_apart, interval_text, number, scale_of, si_scale, si_text)
from booster_ros.report.markup import cell, number_cell, row, table
from booster_ros.report.errors import error_scale
from booster_ros.report.names import channel_label, effect_label

MOST_SUSPECTS = 12

HARDLY_TOLD = 0.8
"""Width of the interval of a parameter, relative to that of its tolerance, above which a record
hardly tells the parameter."""


def error_table(
    parts: Mapping[str, Mapping[str, ChannelError]], stages: Mapping[str, str]
) -> str:
    """
    Return errors by part of the data and channel.

    `parts` maps words for a part ('held out') to its errors, `stages` the fields of ChannelError
    that are shown to words for them.
    """
    rows = []
    for part, errors in parts.items():
        rows.append(f'<tr class="group"><td colspan="{len(stages) + 2}">{part}</td></tr>')
        for name, error in errors.items():
            cells = [cell(channel_label(name))]
            scale = error_scale(error)
            for stage in (*stages, 'noise'):
                value = getattr(error, stage)
                ratio = value / error.noise
                times = '' if stage == 'noise' or not math.isfinite(ratio) else (
                    f'{number(ratio, 2 if ratio < 10 else 3)} × noise')
                cells.append(number_cell(scale.text(value), times))
            rows.append(row(cells))
    return table(['root mean square error', *stages.values(), 'noise'], rows)


def effect_table(effect: FoundEffect) -> str:
    """Return the parameters of an effect with their intervals."""
    rows = []
    for name, interval in effect.parameters.items():
        ends = interval.low, interval.high
        scale = common_scale(interval.unit, (interval.value, *ends))
        digits = digits_apart(*ends)
        text, physics = (interval_text(each, *ends, digits, interval.open_above)
                         for each in (scale, si_scale(interval.unit)))
        rows.append(row([
            _parameter_cell(name),
            number_cell('none') if interval.is_none else _both_units(
                scale, interval.value, interval.unit, digits),
            number_cell(text, '' if text == physics else physics),
        ]))
    return table(['parameter', 'value', '95 % interval'], rows)


def _parameter_cell(name: str) -> str:
    """Return a cell with a parameter's name ([n] for an element of it) above its meaning."""
    description = DESCRIPTIONS.get(name.split('[')[0])
    meaning = escape(description.meaning.split(': ', 1)[-1]) if description else ''
    return f'<td><code>{escape(name)}</code><small>{meaning}</small></td>'


def _both_units(scale: Scale, value: float, unit: str, digits: int) -> str:
    """Return a cell with a value as people read it, above the value in SI where they differ."""
    text, physics = scale.text(value, digits), si_text(value, unit, digits)
    return number_cell(text, '' if text == physics else physics)


def shown_suspects(diagnosis: Diagnosis) -> tuple[Suspect, ...]:
    """
    Return the choice, then the best of the models that were tried, by their misfit.

    The model of the reported effects and the declared model are among them wherever they rank.
    """
    reported = {tuple(effect.name for effect in diagnosis.effects), ()}
    ranked = sorted(diagnosis.suspects, key=lambda one: (
        not one.reason.startswith('chosen'), not one.misfit < math.inf, one.misfit))
    return tuple(one for place, one in enumerate(ranked) if place < MOST_SUSPECTS
                 or one.effects in reported or one.reason.startswith('chosen'))


def suspect_table(diagnosis: Diagnosis) -> str:
    """Return the models that were tried, with the reason each was dropped."""
    suspects = shown_suspects(diagnosis)
    largest = max((s.misfit for s in suspects if math.isfinite(s.misfit)), default=1.0)
    chosen = tuple(effect.name for effect in diagnosis.effects)
    rows = [_suspect_row(s, largest, s.effects == chosen or s.reason.startswith('chosen'))
            for s in suspects]
    return table(['model', 'misfit', '', 'why'], rows, 9)


def _suspect_row(suspect: Suspect, largest: float, chosen: bool) -> str:
    words = ' + '.join(effect_label(name) for name in suspect.effects) or 'declared model, refitted'
    return row([
        cell(words), number_cell(number(suspect.misfit)),
        f'<td>{_bar(suspect.misfit, largest, chosen)}</td>', cell(suspect.reason),
    ], 'chosen' if chosen else '')


def _bar(misfit: float, largest: float, chosen: bool) -> str:
    """Return a bar on a logarithmic scale, empty at the noise."""
    if not math.isfinite(misfit):
        return ''
    share = math.log(max(misfit, 1.0)) / math.log(max(largest, 1.1))
    colour = '#0072b2' if chosen else '#b4c0ca'
    return ('<svg class="bar" viewBox="0 0 100 8" preserveAspectRatio="none" aria-hidden="true">'
            f'<rect width="{max(100.0 * share, 0.8):.1f}" height="8" fill="{colour}"/></svg>')


def declared_table(refitted: tuple[Refitted, ...], stages: Mapping[str, str]) -> str:
    """Return the declared parameters, as given and refitted."""
    rows = []
    for one in refitted:
        scale = scale_of(one.unit)
        cells = [_parameter_cell(one.name), _both_units(scale, one.given, one.unit, 4)]
        for stage in stages:
            away = round(getattr(one, f'away_{stage}'), 1) + 0.0  # no minus zero
            small = 'free' if one.spread is None else f'{away:+.1f} σ'.replace('-', '−')
            cells.append(number_cell(scale.text(getattr(one, stage), 4), small))
        rows.append(row([*cells, _interval_cell(one, scale)]))
    return table(['declared parameter', 'as given', *stages.values(), '95 % interval'], rows)


def hardly_told(one: Refitted) -> bool:
    """Tell whether the record tells a parameter hardly closer than it was known before."""
    return one.width > HARDLY_TOLD and abs(one.away_after) < FAR_OFF


def _interval_cell(one: Refitted, scale: Scale) -> str:
    """Return the interval of a declared parameter, and whether the record tells it at all."""
    if not math.isfinite(one.high - one.low):
        return number_cell('–', 'at its limit' if one.at_limit else '')
    digits = max(4, digits_apart(one.low, one.high))
    return number_cell(
        interval_text(scale, one.low, one.high, digits),
        'hardly told by this record' if hardly_told(one) else '')
