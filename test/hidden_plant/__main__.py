# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Write a folder of records of valves with hidden effects."""

import argparse
from pathlib import Path
import sys

from .campaigns import every, single, unseen
from .cases import Case, write_cases
from .currents import KINDS
from .declared import SPREADS
from .effects import CATALOGUED, SIZES, UNCATALOGUED


def main(args: list[str] | None = None) -> int:
    """Run the program; return its exit status."""
    options = _parser().parse_args(args)
    try:
        cases = [case for text in options.cases for case in _cases(text, options)]
    except ValueError as error:
        print(f'hidden_plant: {error}', file=sys.stderr)
        return 2
    for number, name in enumerate(write_cases(cases, options.out), start=1):
        print(f'{number}/{len(cases)} {name}', flush=True)
    return 0


def _cases(text: str, options: argparse.Namespace) -> list[Case]:
    if text == 'unseen':
        return unseen(options.seed, options.spread)
    group = {'catalogued': CATALOGUED, 'uncatalogued': UNCATALOGUED}.get(text)
    if group is not None:
        return every(group, options.size, options.seed, options.kind, options.spread)
    return [single(text, options.seed, options.kind, options.spread)]


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog='hidden_plant', description=__doc__)
    parser.add_argument('--out', type=Path, required=True, help='folder to write')
    parser.add_argument(
        '--cases',
        nargs='+',
        default=['unseen'],
        help='unseen (31 drawn cases), catalogued, uncatalogued, none, or EFFECT[:SIZE][+EFFECT…]',
    )
    parser.add_argument('--seed', type=int, default=1)
    parser.add_argument('--size', choices=SIZES, default='medium', help='of the two groups')
    parser.add_argument('--kind', choices=KINDS, default='mixed', help='test signal of named cases')
    parser.add_argument('--spread', choices=SPREADS, default='samples', help='of the parameters')
    return parser


if __name__ == '__main__':
    sys.exit(main())
