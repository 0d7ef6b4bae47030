# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Print the table of all parameters as Markdown, for the documentation.

    python -m booster_ros.parameters.table
"""

import math

from ..model.parameters import Description
from .schema import ALL_DESCRIPTIONS, READ_ONLY


def parameter_table() -> str:
    """Return a Markdown table with a row for each parameter."""
    lines = ['| parameter | default | unit | range | meaning | the default is from |',
             '|---|---|---|---|---|---|']
    lines += [_row(description) for description in ALL_DESCRIPTIONS.values()]
    return '\n'.join(lines) + '\n'


def _row(description: Description) -> str:
    name = f'`{description.name}`' + (' (read-only)' if description.name in READ_ONLY else '')
    return (
        f'| {name} | {_default(description)} | {description.unit} | {_range(description)} '
        f'| {description.meaning} | {description.source} |')


def _default(description: Description) -> str:
    default = description.default
    if isinstance(default, bool):
        return str(default).lower()
    if isinstance(default, tuple):
        return f'[{", ".join(f"{number:g}" for number in default)}]'
    return default if isinstance(default, str) else f'{default:.8g}'


def _range(description: Description) -> str:
    if description.choices:
        return ', '.join(description.choices)
    if isinstance(description.default, bool):
        return 'true, false'
    if math.isinf(description.high):
        return 'finite'
    return f'{description.low:g} to {description.high:g}'


if __name__ == '__main__':
    print(parameter_table(), end='')
