# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Print the table of a node's parameters as Markdown, for the documentation.

    python -m booster_ros.parameters.table [positioner | fake_controller]
"""

from collections.abc import Collection, Mapping
import math
import sys

from ..control import settings as fake_controller
from ..model.parameters import Description
from .schema import ALL_DESCRIPTIONS, READ_ONLY


def parameter_table(
    descriptions: Mapping[str, Description] = ALL_DESCRIPTIONS,
    read_only: Collection[str] = READ_ONLY,
) -> str:
    """Return a Markdown table with a row for each parameter, the positioner's unless told."""
    lines = ['| parameter | default | unit | range | meaning | the default is from |',
             '|---|---|---|---|---|---|']
    lines += [
        _row(description, description.name in read_only) for description in descriptions.values()]
    return '\n'.join(lines) + '\n'


def _row(description: Description, is_read_only: bool) -> str:
    name = f'`{description.name}`' + (' (read-only)' if is_read_only else '')
    return (
        f'| {name} | {_default(description)} | {description.unit} | {_range(description)} '
        f'| {description.meaning} | {description.source} |')


def _default(description: Description) -> str:
    default = description.default
    if isinstance(default, bool):
        return str(default).lower()
    if isinstance(default, tuple):
        return f'[{", ".join(f"{number:g}" for number in default)}]'
    return (default or 'empty') if isinstance(default, str) else f'{default:.8g}'


def _range(description: Description) -> str:
    if description.choices:
        return ', '.join(description.choices)
    if isinstance(description.default, bool):
        return 'true, false'
    if isinstance(description.default, str):
        return 'text'
    if math.isinf(description.high):
        return 'finite'
    return f'{description.low:g} to {description.high:g}'


if __name__ == '__main__':
    if sys.argv[1:] == ['fake_controller']:
        print(parameter_table(fake_controller.DESCRIPTIONS, ()), end='')
    else:
        print(parameter_table(), end='')
