# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A mapping as YAML, with what is behind each line beside it, for people to correct."""

from __future__ import annotations

from collections.abc import Iterable
import json

from booster_ros.records.column_summary import Summary
from booster_ros.records.conversion import units_for
from booster_ros.records.inspection import Inspection
from booster_ros.records.mapping import ASKED, TRAVEL, ColumnMapping, FileMapping, Layout
from booster_ros.records.record import COLUMNS, FURTHER

_LONGEST_COMMENT = 100


def mapping_text(found: Inspection, title: str) -> str:
    """Return the YAML of what `inspect` made of a file."""
    mapping = found.mapping
    lines = [f'# How {title} is read. A ? has to be replaced; a line that is wrong may go.',
             f'# Columns of a record: {", ".join(name for name in COLUMNS if name != "time")};',
             f'# beside: {", ".join(FURTHER)}. Units: any, such as kPa, psi, mA, mm.']
    lines += _layout(mapping.layout)
    lines += _time(found)
    if mapping.long:
        lines.append(f'long: {{tag: {scalar(mapping.long.tag)}, '
                     f'value: {scalar(mapping.long.value)}}}')
    lines.append('columns:')
    for guess in found.guesses:
        lines.append(f'  {guess.column}: {_column(guess.mapping)}'
                     f'{_comment(_asked(guess.column, guess.asked) or guess.why)}')
    used = {one.mapping.source for one in found.guesses}
    used |= {found.columns[place].reference for place in found.time.places
             if place < len(found.columns)}
    used |= {one.column for one in mapping.quality}
    for one in found.columns:
        if one.reference not in used and one.count:
            lines.append(f'  # NAME: {_column(ColumnMapping(one.reference, ASKED))}'
                         f'{_comment(_range(one))}')
    if not found.guesses:
        lines.append('  # give one of these lines above a name, such as chamber_pressure, and a '
                     'unit')
    lines += _rest(mapping)
    return '\n'.join(lines) + '\n'


def _layout(layout: Layout) -> list[str]:
    told = [f'{name}: {scalar(value)}' for name, value in layout.__dict__.items()
            if value is not None]
    return [f'file: {{{", ".join(told)}}}'] if told else []


def _time(found: Inspection) -> list[str]:
    time = found.mapping.time
    if time is None:
        return [f'# {found.time.why}']
    names = [scalar(name) for name in time.columns]
    parts = [f'columns: [{", ".join(names)}]'] if names else []
    parts += [f'{name}: {scalar(value)}' for name, value in (
        ('unit', time.unit), ('format', time.format), ('zone', time.zone), ('every', time.every),
        ('stamps', time.stamps)) if value is not None]
    return [f'time: {{{", ".join(parts)}}}{_comment(found.time.asked or found.time.why)}']


def _column(one: ColumnMapping) -> str:
    parts = [f'from: {scalar(one.source)}']
    parts += [f'{name}: {scalar(value)}' for name, value in (
        ('unit', one.unit), ('of', one.of), ('gauge', one.gauge)) if value is not None]
    return f'{{{", ".join(parts)}}}'


def _rest(mapping: FileMapping) -> list[str]:
    lines = []
    if mapping.missing:
        lines.append(f'missing: [{", ".join(map(scalar, mapping.missing))}]')
    if mapping.quality:
        each = []
        for one in mapping.quality:
            of = f', of: [{", ".join(one.of)}]' if one.of else ''
            each.append(f'{{column: {scalar(one.column)}, '
                        f'good: [{", ".join(map(scalar, one.good))}]{of}}}')
        lines += ([f'quality: {each[0]}'] if len(each) == 1
                  else ['quality:', *(f'  - {text}' for text in each)])
    if mapping.held:
        lines.append(f'held: [{", ".join(mapping.held)}]  # stored by exception: a value holds '
                     'until the next')
    if mapping.run is not None:
        lines.append(f'run: {mapping.run}  # of several in this file')
    if mapping.travel is not None:
        lines.append(f'travel: {scalar(mapping.travel)}')
    elif any(one.of == TRAVEL for one in mapping.columns.values()):
        lines.append('# travel: 20 mm  # of the stem, where no parameter file says it')
    return lines


def _asked(column: str, asked: Iterable[str]) -> str:
    hints = {'unit': f'unit: {" or ".join(units_for(column))}?',
             'gauge': 'gauge: true or false (absolute)?', 'of': 'of: [4 mA, 20 mA]?'}
    return ' '.join(hints[one] for one in asked)


def _range(one: Summary) -> str:
    return f'{one.low:.6g} to {one.high:.6g}'


def _comment(text: str) -> str:
    words = ' '.join(text.split())
    short = words if len(words) <= _LONGEST_COMMENT else words[:_LONGEST_COMMENT] + ' …'
    return f'  # {short}' if short else ''


def scalar(value: object) -> str:
    """Return a value as YAML within brackets, quoted where it is text that could be anything."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, (list, tuple)):
        return f'[{", ".join(map(scalar, value))}]'
    if isinstance(value, (int, float)):
        return repr(value)
    text = str(value)
    if text.isidentifier() and text.isascii() and text.lower() not in (
            'true', 'false', 'yes', 'no', 'on', 'off', 'null', 'none', 'y', 'n'):
        return text
    return json.dumps(text, ensure_ascii=False)
