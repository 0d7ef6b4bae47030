# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What every program that reads a record takes: `--map`, `--column`; and how it refuses one."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from contextlib import contextmanager
import os
from pathlib import Path
import shlex

from ..legible import legible
from ..records import COLUMNS, FURTHER, FileMapping, RecordError, is_bag, read_mapping
from ..records.mapping import ColumnMapping
from .path_argument import given_path


def add_mapping_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that say how a file of others is read."""
    parser.add_argument(
        '--map', type=given_path, metavar='M.yaml',
        help='how the file is read, as inspect writes it and you correct it')
    parser.add_argument(
        '--column', type=column_in_short, action='append', default=[], metavar='NAME=FROM',
        help="a column in short, as in valve_position='Travel [%%]'; again for each")


def column_in_short(text: str) -> tuple[str, str]:
    """Return name and source, for argparse."""
    name, _, source = text.partition('=')
    if name not in (*COLUMNS, *FURTHER) or not source.strip():
        raise argparse.ArgumentTypeError(
            f'{text!r} is not NAME=FROM with a name of a record: {", ".join((*COLUMNS, *FURTHER))}')
    return name, source


def mapping_for(path: Path, options: argparse.Namespace) -> FileMapping | None:
    """Return the mapping that the options give for a file, None where they give none."""
    mapping = read_mapping(options.map) if options.map else None
    if not options.column:
        return mapping
    if is_bag(path):
        columns = {**(mapping.columns if mapping else {}),
                   **{name: ColumnMapping(source) for name, source in options.column}}
        return FileMapping('--column', columns, mapping.time if mapping else None)
    # only who asks for it waits for pandas
    from ..records.own_names import with_columns
    return with_columns(path, mapping, dict(options.column))


@contextmanager
def pointing_to_inspect(path: Path | str) -> Iterator[None]:
    """End what a record is refused with in the command that shows what its file holds."""
    try:
        yield
    except RecordError as error:
        if not os.path.exists(path) or HINT in str(error):
            raise
        raise RecordError(f'{error}; {HINT} {shlex.quote(legible(path))}') from None


HINT = 'what the file holds says: python -m booster_ros inspect'
