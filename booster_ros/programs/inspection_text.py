# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What `inspect` prints of a file, and of what is read from it."""

from __future__ import annotations

import numpy as np

from ..records.bag_inspection import BagInspection
from ..records.column_summary import MOST_ROWS, Summary
from ..records.inspection import Inspection
from ..records.record import COLUMNS, Record
from ..records.time_axis import gap_rows

_LONGEST = 28
_NAMES = {'\t': 'tabs', ',': 'commas', ';': 'semicolons', '|': 'bars', 'spaces': 'spaces'}


def inspection_lines(found: Inspection) -> list[str]:
    """Return the lines on a table."""
    table = found.table
    lines = [f'{table.source}: {table.kind}, {_rows(found)}']
    layout = table.layout
    if layout.delimiter:
        parts = [f'columns separated by {_NAMES.get(layout.delimiter, repr(layout.delimiter))}',
                 f"decimal sign '{layout.decimal}'"]
        if layout.thousands:
            parts.append(f"thousands separated by '{layout.thousands}'")
        parts.append(f'encoding {layout.encoding}')
        lines.append('  ' + ', '.join(parts))
    if layout.first:
        named = (f'line {layout.header} names the columns' if layout.header
                 else 'no line names the columns')
        lines.append(f'  {named}, data from line {layout.first} on')
    if table.preamble:
        lines.append('  above that: ' + ' | '.join(
            ' '.join(line.split())[:60] for line in table.preamble[:6] if line.strip()))
    lines += ['', *_time_lines(found), '', *_table(found)]
    for quality in found.mapping.quality:
        lines.append(f'  quality: column {quality.column!r} is taken to mean good where it says '
                     f'{" or ".join(map(str, quality.good))}')
    if found.mapping.missing:
        lines.append('  no value: ' + ', '.join(map(repr, found.mapping.missing)))
    if found.mapping.held:
        lines.append(f'  stored by exception: {", ".join(found.mapping.held)}: most rows have no '
                     'value, the one before holds')
    lines += [f'  note: {note}' for note in found.notes]
    return lines


def _rows(found: Inspection) -> str:
    rows = max((one.rows for one in found.columns), default=0)
    if found.mapping.long:
        return f'a long table of {len(found.columns)} tags'
    return f'the first {MOST_ROWS} rows looked at' if found.more else f'{rows} rows'


def _time_lines(found: Inspection) -> list[str]:
    mapping = found.mapping.time
    if mapping is None:
        return [f'time: {found.time.why}']
    what = ' and '.join(map(repr, mapping.columns)) or f'every {mapping.every}'
    how = mapping.unit or mapping.format or 'ISO 8601'
    lines = [f'time: {what}, {how} ({found.time.why})']
    if found.seconds is not None:
        lines += _sampling(found.seconds)
    return lines


def _sampling(time: np.ndarray) -> list[str]:
    known = time[np.isfinite(time)]
    steps = np.diff(np.sort(known))
    if steps.size < 2:
        return []
    low, middle, high = np.quantile(steps, [0.05, 0.5, 0.95])
    lines = [f'  {known.size} rows over {np.ptp(known):.6g} s, every {middle:.4g} s '
             f'(90 % of the steps: {low:.4g} to {high:.4g} s)']
    gaps = gap_rows(np.sort(known))
    if gaps.size:
        longest = float(np.max(steps[gaps - 1]))
        lines.append(f'  {gaps.size} gaps, the longest {longest:.4g} s')
    return lines


def _table(found: Inspection) -> list[str]:
    guessed = {str(one.mapping.source): one for one in found.guesses}
    quality = {str(one.column) for one in found.mapping.quality}
    rows = [('column', 'first', 'least', 'most', 'missing', 'taken for')]
    for one in found.columns:
        guess = guessed.get(str(one.reference))
        if guess:
            unit = '' if guess.mapping.unit == '?' else guess.mapping.unit
            meaning = f'{guess.column}, {unit or "unit not said"} ({guess.why})'
        elif one.place in found.time.places:
            meaning = 'time'
        else:
            meaning = 'quality' if str(one.reference) in quality else '-'
        rows.append((_name(one), *_numbers(one), meaning))
    widths = [max(len(row[k]) for row in rows) for k in range(5)]
    return ['  ' + '  '.join([row[0].ljust(widths[0]),
                              *(row[k].rjust(widths[k]) for k in range(1, 5)), row[5]])
            for row in rows]


def _name(one: Summary) -> str:
    name = one.name if len(one.name) <= _LONGEST else one.name[:_LONGEST - 1] + '…'
    unit = f' [{one.unit_row.strip("[]() ")}]' if one.unit_row.strip('[]() ') else ''
    return ''.join(character if character.isprintable() else '?' for character in name + unit)


def _numbers(one: Summary) -> tuple[str, str, str, str]:
    missing = str(one.rows - one.count) if one.count else '0'
    if one.is_date or (one.is_text and one.samples):
        first = one.samples[0][:22] if one.samples else 'date'
        return first, '', '', str(one.empty)
    if not one.count:
        return '', '', '', str(one.rows)
    return f'{one.first:.7g}', f'{one.low:.7g}', f'{one.high:.7g}', missing


def bag_lines(bag: BagInspection) -> list[str]:
    """Return the lines on a bag."""
    lines = [f'{bag.source}: a bag of {len(bag.topics)} topics']
    for one in bag.topics:
        span = f', {one.low:.6g} to {one.high:.6g}' if one.count else ''
        element = f':{one.element}' if one.element else ''
        meaning = one.column or '-'
        lines.append(f'  {one.topic}{element}  {one.kind}, {one.count} messages{span}  {meaning}')
    lines += [f'  note: {note}' for note in bag.notes]
    return lines


def record_lines(record: Record) -> list[str]:
    """Return the lines on a record that was read."""
    lines = [f'  {len(record)} rows']
    if 'time' in record.columns:
        lines += _sampling(record['time'])
    else:
        lines.append('  no time: a quasi-static sweep in row order')
    units = {name: COLUMNS[name].unit for name in record.columns if name != 'time'}
    units |= {name: one.unit for name, one in record.beside.items()}
    for name, unit in units.items():
        values = record[name]
        known = values[np.isfinite(values)]
        span = f'{known[0]:.7g} at first, {known.min():.7g} to {known.max():.7g} {unit}' if (
            known.size) else 'no value'
        gauge = ' gauge' if unit == 'Pa' and name not in ('pressure_drop', 'process_value',
                                                          'process_set_point') else ''
        lines.append(f'  {name}: {span}{gauge}, {len(values) - known.size} missing')
    lines += [f'  note: {note}' for note in record.notes]
    return lines
