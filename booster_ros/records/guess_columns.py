# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which column of a record one of a file most likely is: by its name, its label, unit and range."""

from __future__ import annotations

import re
from typing import NamedTuple

import numpy as np

from booster_ros.records.column_summary import Summary
from booster_ros.records.conversion import Unit, parsed_unit, si_units
from booster_ros.records.mapping import ASKED, TRAVEL, ColumnMapping
from booster_ros.records.missing import is_good
from booster_ros.records.reading import AS_THEY_ARE, HALF_VACUUM
from booster_ros.records.record import COLUMNS, FURTHER, RecordError
from booster_ros.records.unit_in_name import named, normalised
from booster_ros.records.units import check_pressure_scale, check_units

_WORDS: tuple[tuple[str, str], ...] = (
    ('valve_position', r'position_feedback|travel_feedback|feedback_pos\w*'),
    ('set_point', r'set_?p(oin)?t|setpoint|\bsp\b|\bsv\b|target|demand|sollwert|consigne|'
                  r'reference|desired|\bmv\b|\bop\b|\bout(put)?\b|\bco\b'),
    ('supply_pressure', r'supply|instrument_air|\binlet|versorg|zuluft|\bp_?s(up)?\b|p_supply'),
    ('back_pressure', r'nozzle|back_?press|pilot|i_?p_out|signal_press|steuerdruck'),
    ('pressure_drop', r'\bdp\b|delta_?p|pressure_drop|differential|\bpd[it]'),
    ('control_current', r'current|\bstrom\b|\bao\b|\bma\b|\bi_?cmd\b'),
    ('chamber_pressure', r'chamber|actuator_?p|\bp_?act|feedback_?k?pa|press(ure)?|druck|\bp\b|'
                         r'feedback|presion|pression'),
    ('valve_position', r'travel|position|stem|lift|\bhub\b|stroke|stellung|\bpos\b|opening|'
                       r'weg\b|\bz[it]_?\d+|displacement'),
    ('mass_flow', r'mass_?flow'),
    ('process_value', r'\bpv\b|process_value|istwert|\bflow\b|level|temperature'),
)
_KIND = {'A': 'control_current', 'Pa': 'chamber_pressure', 'm': 'valve_position',
         'kg/s': 'mass_flow'}
_TAG_OF_VALVE = re.compile(r'(?i)(^|[^a-z])[a-z]{1,2}c?v[_\-]?\d+')
_TAG_OF_TRANSMITTER = re.compile(r'(?i)(^|[^a-z])[a-z]d?i?t[_\-]?\d+')
_OUTPUT = re.compile(r'(?i)(^|[._\s\d])(mv|op|out|output|co)$')
_LOOP = re.compile(r'(?i)^(?P<loop>.+)[._/](?P<part>mv|op|pv|sv|sp|co|out)$')
_QUALITY = re.compile(
    r'(?i)quality|qualit[äa]t|status|\bq\b|\bbad\b|valid|^b\w*ofl$|_ofl\b|confidence')
_GOOD_WORDS = ('good', 'ok', 'valid', 'true', 'gut', 'g', '192', '0')
_PERCENT = (-5.0, 110.0)


class Guess(NamedTuple):
    """What a column is taken for, how it is mapped, why, and what has to be asked."""

    column: str
    mapping: ColumnMapping
    why: str
    asked: tuple[str, ...] = ()


def guessed_columns(columns: list[Summary], taken: set[int]) -> list[Guess]:
    """Return a guess for each column that looks like one of a record, best known names first."""
    found: dict[str, Guess] = {}
    numbers = [one for one in columns if one.place not in taken and one.count]
    in_loop = _is_loop(numbers)
    for sure in (True, False):
        for one in numbers:
            told = _own_name(one) if sure else _by_words(one, in_loop)
            if told is None or told[0] in found or any(
                    guess.mapping.source == one.reference for guess in found.values()):
                continue
            name, why = told
            guess = _mapped(name, one, why)
            if guess is not None:
                found[guess.column] = guess
    order = [*COLUMNS, *FURTHER]
    return sorted(found.values(), key=lambda guess: order.index(guess.column))


def is_quality(one: Summary) -> bool:
    """Tell whether a column says how good others are: by its name, and by how few values it has."""
    if not _QUALITY.search(one.name):
        return False
    kinds = len(one.words) + len(set(one.values[:10_000][one.values[:10_000] ==
                                                         one.values[:10_000]].tolist()))
    return 0 < kinds <= 8


def good_values(one: Summary) -> list[object]:
    """Return the values of a quality column that most likely mean good."""
    if one.words:
        words = list(one.words)
        good = [word for word in words if word.lower() in _GOOD_WORDS]
        return list(good or words[:1])
    values = {float(value) for value in one.values if value == value}
    flag = re.search(r'(?i)bad|ofl|error|alarm', one.name) is not None
    for candidate in ((0.0,) if flag else (192.0, 1.0, 0.0)):
        if candidate in values:
            return [int(candidate)]
    return [int(min(values))] if values else [0]


def has_bad(one: Summary, good: list[object]) -> bool:
    """Tell whether a quality column ever says that a row is not good."""
    import pandas as pd

    rest = [word for word in one.words if not is_good(pd.Series([word]), good)[0]]
    return bool(rest) or any(value not in good for value in set(one.values.tolist())
                             if value == value)


def _is_loop(columns: list[Summary]) -> bool:
    parts = {match['part'].lower() for one in columns if (match := _LOOP.match(one.name))}
    return len(parts) > 1


def _own_name(one: Summary) -> tuple[str, str] | None:
    name = normalised(named(one.name).name)
    if name in (*COLUMNS, *FURTHER) and name != 'time':
        return name, 'by its name'
    return None


def _by_words(one: Summary, in_loop: bool) -> tuple[str, str] | None:
    bare = re.sub(r'(?<=[a-z])(?=[A-Z])', '_', named(one.name).name)
    text = re.sub(r'[\s.\-/]+', '_', bare).lower()
    spaced = text.replace('_', ' ')
    loop = _LOOP.match(one.name)
    if loop and in_loop:
        part = loop['part'].lower()
        column = {'pv': 'process_value', 'sv': 'process_set_point', 'sp': 'process_set_point'}.get(
            part, 'set_point')
        what = {'process_value': 'process value', 'process_set_point': 'set point of the process',
                'set_point': "output, the positioner's set point"}[column]
        return column, f'a loop with its {what}'
    for column, words in _WORDS:
        if re.search(words.replace('_', '[_ ]'), spaced) and _fits(column, _unit_of(one)):
            return column, f'its name, {one.name!r}, says so'
    if _TAG_OF_VALVE.search(one.name):
        return 'set_point', "the tag is a valve's"
    if _TAG_OF_TRANSMITTER.search(one.name):
        return 'process_value', "the tag is a transmitter's"
    unit = _unit_of(one)
    for target, column in _KIND.items():
        if unit is not None and _measures(unit, target):
            return column, f'it is in {unit.written}'
    return None


def _fits(column: str, unit: Unit | None) -> bool:
    """Tell whether a column may be in a unit."""
    targets = si_units(column)
    if unit is None or not targets:
        return True
    return any(_measures(unit, target) for target in targets) or bool(
        unit.pint.check('[]') and targets != ('Pa',))


def _measures(unit: Unit, target: str) -> bool:
    goal = parsed_unit(target)
    return goal is not None and bool(unit.pint.is_compatible_with(goal.pint.units))


def _unit_of(one: Summary) -> Unit | None:
    for text in (named(one.name).unit, one.unit_row.strip('[](){} ')):
        unit = parsed_unit(text)
        if unit is not None:
            return unit
    return None


def _mapped(column: str, one: Summary, why: str) -> Guess | None:
    unit = _unit_of(one)
    own = normalised(named(one.name).name) == column
    asked: list[str] = []
    if unit is None and own and column in COLUMNS:
        unit = parsed_unit(COLUMNS[column].unit) if _can_be_in_si(column, one) else None
        why += f', in {COLUMNS[column].unit}' if unit else ''
    written: str = unit.written if unit else ASKED
    if unit is None and column == 'set_point' and _is_output(one):
        written, why = '%', why + '; a controller gives its output in per cent'
        unit = parsed_unit('%')
    if unit is None:
        asked.append('unit')
    of = TRAVEL if unit is not None and unit.pint.check('[]') and (
        'm' in si_units(column)) else None
    if unit is not None and unit.pint.check('[]') and column == 'control_current':
        of = ASKED
        asked.append('of')
    gauge = _gauge(column, one, unit, own)
    if gauge == ASKED:
        asked.append('gauge')
    return Guess(column, ColumnMapping(one.reference, written, of, gauge), why, tuple(asked))


def _can_be_in_si(column: str, one: Summary) -> bool:
    """Tell whether the numbers of a column without a unit may be in its own."""
    rows = np.arange(len(one.values))
    try:
        check_units(column, one.values, rows, '')
        check_pressure_scale(column, one.values, rows, '')
    except RecordError:
        return False
    return True


def _is_output(one: Summary) -> bool:
    is_called = _OUTPUT.search(one.name) or _TAG_OF_VALVE.search(one.name)
    return bool(is_called) and one.low >= _PERCENT[0] and 1.5 < one.high <= _PERCENT[1]


def _gauge(column: str, one: Summary, unit: Unit | None, own: bool) -> bool | str | None:
    """Return what is said of gauge and absolute: nothing where there is no pressure, or both."""
    if unit is None or not unit.is_pressure or column in AS_THEY_ARE:
        return None
    if unit.gauge is not None:
        return unit.gauge
    least = one.low * float(unit.pint.to('pascal').magnitude)
    return True if own or least < HALF_VACUUM else ASKED
