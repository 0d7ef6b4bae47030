# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A record of a positioner: named columns in SI units, and what is wrong with them."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

Array = np.ndarray


class RecordError(ValueError):
    """A record cannot be used; the message is one sentence that names file, row and column."""


def needs_rosbags(purpose: str, missing: ModuleNotFoundError) -> RecordError:
    """Return the error to raise where a bag is asked for, and nothing reads or writes bags."""
    return RecordError(
        f'{purpose} needs the Python package {missing.name}, which is not installed: pip install '
        'rosbags')


@dataclass(frozen=True)
class Column:
    """
    A physical quantity that a record may hold.

    `largest` is the largest magnitude that makes sense in SI units. Anything above it was recorded
    in another unit, which `mistaken_for` names.
    """

    unit: str
    meaning: str
    largest: float
    mistaken_for: str


COLUMNS: Mapping[str, Column] = {
    'time': Column('s', 'time', 1e10, 'milliseconds or nanoseconds'),
    'set_point': Column('m', 'position that a position controller is to hold', 0.5,
                        'mm, % or a fraction of travel'),
    'control_current': Column('A', 'current into the E/P converter', 0.1, 'mA'),
    'back_pressure': Column('Pa', 'gauge pressure behind the nozzle', 5e6, 'raw counts'),
    'supply_pressure': Column('Pa', 'gauge pressure of the supply', 5e6, 'raw counts'),
    'mass_flow': Column(
        'kg/s', 'flow out of the booster towards the chamber', 1.0, 'g/s, kg/h or l/min'),
    'chamber_pressure': Column('Pa', 'gauge pressure in the actuator', 5e6, 'raw counts'),
    'valve_position': Column(
        'm', 'stem travel from where it rests vented', 0.5, 'mm, % or a fraction of travel'),
    'pressure_drop': Column('Pa', 'drop of the process pressure over the valve', 5e7, 'raw counts'),
}
"""The columns of a record, most upstream first after `time`; the process comes last."""

COMMANDS = ('set_point', 'control_current')
"""What is commanded, and holds until the next command."""

FURTHER = ('process_value', 'process_set_point')
"""What a mapped record may have beside, in any unit: the model has no channel for it."""

MEASURED = ('chamber_pressure', 'valve_position', 'back_pressure', 'mass_flow', 'supply_pressure')
"""Sensor signals of the positioner; `COMMANDS` change in steps."""

UNKNOWN_COLUMN = 'unknown_column'
"""Kind of the defect that a column is not one of `COLUMNS`."""


@dataclass(frozen=True)
class Defect:
    """
    Something wrong in a record, and what was done about it.

    Rows count as a text editor shows the lines of a CSV (the header is line 1), or as the messages
    of the bag's time base (the first is 1). They are 0 where a defect is not in particular rows.
    """

    kind: str
    column: str
    first_row: int
    last_row: int
    count: int
    treatment: str

    def __str__(self) -> str:
        """Return the sentence for a report."""
        place = _place(self.first_row, self.last_row)
        column = f'column {self.column}' if self.column else ''
        where = ', '.join(part for part in (place, column) if part)
        return f'{where}: {self.treatment}' if where else self.treatment


def _place(first_row: int, last_row: int) -> str:
    if not first_row:
        return ''
    return f'row {first_row}' if first_row == last_row else f'rows {first_row} to {last_row}'


@dataclass(frozen=True)
class Beside:
    """A column for which the model has no channel: its values in SI units, and the unit."""

    values: Array
    unit: str


@dataclass(frozen=True)
class Record:
    """
    Columns of equal length, in SI units, gauge pressures, NaN where a value is missing.

    `time` (s) increases strictly where it is present; without it the rows are a quasi-static sweep.
    A command holds from its row to the next. `rows` says where in the file each row was.
    `beside` has what the model has no channel for: `FURTHER`, and a set point of a pressure, Pa.
    `held` has the columns that were stored by exception, and the least change of each that was
    stored, in its unit.
    """

    columns: Mapping[str, Array]
    source: str
    defects: tuple[Defect, ...]
    rows: Array
    beside: Mapping[str, Beside] = field(default_factory=dict)
    held: Mapping[str, float] = field(default_factory=dict)

    def __len__(self) -> int:
        """Return the number of rows."""
        return len(self.rows)

    def __contains__(self, column: str) -> bool:
        """Say whether the record has the column, for the model or beside."""
        return column in self.columns or column in self.beside

    def has_rows_of(self, other: 'Record') -> bool:
        """Tell whether two records, in two files, are one."""
        return self.columns.keys() == other.columns.keys() and all(
            np.array_equal(values, other[name], equal_nan=True)
            for name, values in self.columns.items())

    def __getitem__(self, column: str) -> Array:
        """Return the values of a column, for the model or beside."""
        return self.beside[column].values if column in self.beside else self.columns[column]

    @property
    def notes(self) -> tuple[str, ...]:
        """Everything that was dropped, mended or found odd, one sentence each."""
        return tuple(str(defect) for defect in self.defects)

    @property
    def ignored(self) -> tuple[str, ...]:
        """Those of the notes that are on columns not among `COLUMNS`."""
        return tuple(str(one) for one in self.defects if one.kind == UNKNOWN_COLUMN)

    def since(self, time: float) -> 'Record':
        """Return the rows from this time (s) on; KeyError for a record without time."""
        kept = slice(int(np.searchsorted(self.columns['time'], time)), None)
        columns = {name: values[kept] for name, values in self.columns.items()}
        beside = {name: replace(one, values=one.values[kept]) for name, one in self.beside.items()}
        return replace(self, columns=columns, rows=self.rows[kept], beside=beside)
