# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A set of records with a little noise on every value, to see what an answer hangs on."""

from collections.abc import Iterator
import json
from pathlib import Path
import shutil
import zlib

import numpy as np

DIGITS = 15


def write_disturbed(given: Path, folder: Path, ratio: float, seed: int) -> Iterator[str]:
    """
    Copy a set with each value v of its records as v (1 + ratio e), e standard normal.

    Time and currents are values as well; a 0 stays one. Yields the name of each case when its files
    are there. ValueError where a record has what is no number, or the set would replace itself.
    """
    if folder.resolve() == given.resolve():
        raise ValueError(f'{folder}: is the set itself')
    key = json.loads((given / 'key.json').read_text(encoding='utf-8'))
    folder.mkdir(parents=True, exist_ok=True)
    shutil.copy(given / 'key.json', folder)
    for case in sorted(key):
        shutil.copy(given / f'{case}.yaml', folder)
        for path in (given / f'{case}_fit.csv', given / f'{case}_val.csv'):
            if path.exists():
                generator = np.random.default_rng([seed, zlib.crc32(path.name.encode())])
                text = path.read_text(encoding='utf-8')
                try:
                    disturbed = disturbed_text(text, ratio, generator)
                except ValueError as error:
                    raise ValueError(f'{path}: {error}') from None
                (folder / path.name).write_text(disturbed, encoding='utf-8')
        yield case


def disturbed_text(text: str, ratio: float, generator: np.random.Generator) -> str:
    """Return the text of a CSV file with its values disturbed; empty cells stay empty."""
    head, *lines = text.splitlines()
    rows = [line.split(',') for line in lines]
    drawn = iter(generator.standard_normal(sum(map(len, rows))))
    return '\n'.join([head, *(
        ','.join(_disturbed(cell, ratio * next(drawn)) for cell in row) for row in rows)]) + '\n'


def _disturbed(cell: str, part: float) -> str:
    return f'{float(cell) * (1.0 + part):.{DIGITS}g}' if cell.strip() else cell
