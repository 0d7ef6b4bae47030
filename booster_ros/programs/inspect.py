# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Say what a file holds, and write a mapping that tells how it is read."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
import os
from pathlib import Path
import shlex
import sys
import tempfile

import numpy as np

from ..legible import legible
from ..records import CsvWriter, RecordError, is_bag, read_mapping, read_record
from ..records.bag_inspection import inspect_bag
from ..records.inspection import inspect, is_plain
from ..records.mapping import FileMapping
from ..records.mapping_text import mapping_text
from ..records.record import COLUMNS, Record
from ..records.target import check_inputs_stay, replaced_by
from .inspection_text import bag_lines, inspection_lines, record_lines
from .path_argument import given_path

SUFFIX = '.map.yaml'
"""How the name of a mapping ends that was not given one."""


def main(args: Sequence[str] | None = None) -> int:
    """Print what a file holds and write the mapping; return the exit status."""
    options = _parser().parse_args(args)
    try:
        _inspect(options)
    except RecordError as error:
        print(f'inspect: {error}', file=sys.stderr)
        return 2
    except OSError as error:
        print(f'inspect: {error.filename}: {error.strerror}', file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print('inspect: interrupted', file=sys.stderr)
        return 130
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog='inspect',
        description='Say what a file of whatever logger holds, and write a mapping to correct by '
        'hand: which of its columns are those of a record, in which unit.',
        epilog='Where the mapping is there already it is not written again: it is what the file is '
        'read with, and what comes out is shown.')
    add = parser.add_argument
    add('file', type=given_path, metavar='FILE',
        help='text, Excel, Parquet, Feather, MATLAB, JSON lines, compressed or not; or a bag')
    add('--map', type=given_path, metavar='M.yaml',
        help=f'the mapping (default: NAME{SUFFIX} in the current folder)')
    add('--plot', type=given_path, metavar='P.html', help='a page with all columns over time')
    add('--csv', type=given_path, metavar='R.csv',
        help='the record that the mapping makes of the file, in SI units')
    return parser


def _inspect(options: argparse.Namespace) -> None:
    target = options.map or Path(_stem(options.file) + SUFFIX)
    written = [path for path in (options.plot, options.csv) if path is not None]
    check_inputs_stay([options.file, target], written, '--plot or --csv')
    check_inputs_stay([options.file], [target], '--map')
    if os.path.lexists(target):
        _with_mapping(options, target)
        return
    if is_bag(options.file):
        bag = inspect_bag(options.file)
        text, asked = bag.text, bag.asked
        lines = bag_lines(bag)
        found = None
    else:
        found = inspect(options.file)
        text, asked = mapping_text(found, legible(options.file.name)), found.asked
        lines = inspection_lines(found)
    print('\n'.join(lines))
    _write(target, text)
    print(f'\nMapping written to {legible(target)}. '
          + _next(options, target, asked, found is not None and is_plain(found)))
    if options.plot:
        from .look import look_at_bag, look_at_table
        _write(options.plot, look_at_table(found) if found else look_at_bag(bag))
    if options.csv:
        if asked:
            raise RecordError(f'{legible(target)}: answer its questions first; then the record '
                              'can be written')
        _write_record(options.csv, read_record(options.file, mapping=read_mapping(target)))


def _with_mapping(options: argparse.Namespace, path: Path) -> None:
    """Show what a file is read as with a mapping that is there."""
    mapping = read_mapping(path)
    record = read_record(options.file, mapping=mapping)
    print(f'{legible(options.file)}, read as {legible(path)} says:')
    print('\n'.join(record_lines(record)))
    print(f'\nUse it:\n  {_command(options.file, path, mapping)}')
    if options.plot:
        from .look import look_at_record  # plots take as long to load as all else here
        _write(options.plot, look_at_record(options.file, record))
    if options.csv:
        _write_record(options.csv, record)


def _next(options: argparse.Namespace, target: Path, asked: Sequence[str], plain: bool) -> str:
    again = f'python -m booster_ros inspect {shlex.quote(str(options.file))}'
    if options.map:
        again += f' --map {shlex.quote(str(target))}'
    if asked:
        return ('Answer what is asked in it:\n' + '\n'.join(f'  {one}' for one in asked)
                + f'\nthen see what comes out:\n  {again}')
    tail = ' (it needs none: all columns have their names and units)' if plain else ''
    return (f'See what comes out{tail}:\n  {again}\nor use it:\n  '
            f'{_command(options.file, target, None)}')


def _command(file: Path, mapping: Path, read: FileMapping | None) -> str:
    """Return the command that uses a mapping."""
    return (f'python -m booster_ros close_loop --record {shlex.quote(str(file))} '
            f'--map {shlex.quote(str(mapping))} --params valve.yaml --out result')


def _stem(file: Path) -> str:
    name = file.resolve().name if file.name in ('', '.', '..') else file.name
    for suffix in ('.gz', '.bz2', '.xz', '.zst'):
        name = name.removesuffix(suffix)
    return Path(name).stem or name


def _write(path: Path, text: str) -> None:
    """Write a file at once, or leave what is there."""
    target = replaced_by(path)
    descriptor, name = tempfile.mkstemp(dir=target.parent, prefix=f'.{target.name[:40]}.')
    try:
        with os.fdopen(descriptor, 'w', encoding='utf-8') as file:
            file.write(text)
        os.chmod(name, 0o644)
        os.replace(name, target)
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise


def _write_record(path: Path, record: Record) -> None:
    names = [name for name in COLUMNS if name in record.columns]
    others = list(record.beside)
    with CsvWriter(path, [*names, *others]) as writer:
        writer.write_rows(np.column_stack([record[name] for name in (*names, *others)]))


if __name__ == '__main__':
    sys.exit(main())
