# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Print the figures of a control valve from a record of set point and position."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
import json
import os
from pathlib import Path
import sys
import tempfile

from ..metrics.figures import as_plain, figures_of
from ..metrics.text import text_of
from ..records import RecordError, check_inputs_stay, read_record
from .interruption import kept_interruption
from .path_argument import given_path


def main(args: Sequence[str] | None = None) -> int:
    """Print the figures of a record; return the exit status."""
    options = _parser().parse_args(args)
    try:
        with kept_interruption():
            _run(options)
    except RecordError as error:
        print(f'metrics: {error}', file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print('metrics: interrupted', file=sys.stderr)
        return 130
    return 0


def _run(options: argparse.Namespace) -> None:
    if options.out is not None:
        check_inputs_stay([options.record], [options.out], '--out')
    record = read_record(options.record)
    for note in record.notes:
        print(f'{options.record}: {note}', file=sys.stderr)
    figures = figures_of(record)
    if options.out is not None:
        _write(options.out, json.dumps(as_plain(figures), indent=2, allow_nan=False) + '\n')
    print(text_of(figures, options.travel))


def _write(path: Path, text: str) -> None:
    """Write a file whole or not at all; RecordError where that cannot be."""
    try:
        handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f'.{path.name}.')
        try:
            with open(handle, 'w', encoding='utf-8') as stream:
                stream.write(text)
            os.replace(temporary, path)
        except BaseException:
            os.unlink(temporary)
            raise
    except OSError as error:
        raise RecordError(f'{path}: cannot be written: {error.strerror}') from None


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog='metrics',
        description='Print dead time, T63, T86, T98, overshoot, travel gain, dead band, '
        'resolution, hysteresis, limit cycles and stick-slip of a control valve.',
        epilog='R is a CSV file or a rosbag2 bag with time (s), set_point (m) and valve_position '
        '(m). No model is needed. What the figures mean: docs/metrics.md.')
    add = parser.add_argument
    add('--record', type=given_path, required=True, metavar='R', help='the record')
    add('--travel', type=_travel, metavar='L',
        help='travel of the stem, m: lengths are then in %% of it, else in mm')
    add('--out', type=given_path, metavar='FILE.json', help='write the figures there, in SI')
    return parser


def _travel(text: str) -> float:
    try:
        travel = float(text)
    except ValueError:
        travel = 0.0
    if not 0.0 < travel <= 2.0:
        raise argparse.ArgumentTypeError(f'must be metres, above 0 and at most 2, got {text!r}')
    return travel


if __name__ == '__main__':
    sys.exit(main())
