# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Write a folder of records of valves with hidden effects, or disturb one that is there."""

import argparse
from pathlib import Path
import sys

from . import loop
from .campaigns import every, single, unseen
from .cases import Case, write_cases
from .currents import KINDS
from .declared import SPREADS
from .disturbance import write_disturbed
from .effects import CATALOGUED, SIZES, UNCATALOGUED
from .sets import add_samples, golden, ladder, quick

SETS = {'golden': golden, 'quick': quick, 'ladder': ladder}


def main(args: list[str] | None = None) -> int:
    """Run the program; return its exit status."""
    options = _parser().parse_args(args)
    try:
        if (options.disturb is None) != (options.of is None):
            raise ValueError('--disturb and --of go together')
        if options.of:
            for name in write_disturbed(options.of, options.out, options.disturb, options.seed):
                print(name, flush=True)
            return 0
        if options.cases == ['loop']:
            for name in loop.write_cases(loop.drawn(options.seed), options.out):
                print(name, flush=True)
            return 0
        cases = [case for text in options.cases for case in _cases(text, options)]
    except (OSError, ValueError) as error:
        print(f'hidden_plant: {error}', file=sys.stderr)
        return 2
    for number, name in enumerate(write_cases(cases, options.out), start=1):
        print(f'{number}/{len(cases)} {name}', flush=True)
    if 'golden' in options.cases:
        print('copied', *add_samples(options.out))
    return 0


def _cases(text: str, options: argparse.Namespace) -> list[Case]:
    if text in SETS:
        return SETS[text]()
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
        help='unseen (31 drawn cases), golden (40, always the same), quick (60), ladder (105, of '
        'five noises), loop (30 drawn ones in closed loop, alone), catalogued, uncatalogued, '
        'none, or EFFECT[:SIZE][+EFFECT…]',
    )
    parser.add_argument('--seed', type=int, default=1)
    parser.add_argument('--disturb', type=float, metavar='RATIO',
                        help='of the value: noise on every value of another set, e.g. 1e-7')
    parser.add_argument('--of', type=Path, metavar='FOLDER', help='the set that is disturbed')
    parser.add_argument('--size', choices=SIZES, default='medium', help='of the two groups')
    parser.add_argument('--kind', choices=KINDS, default='mixed', help='test signal of named cases')
    parser.add_argument('--spread', choices=SPREADS, default='samples', help='of the parameters')
    return parser


if __name__ == '__main__':
    sys.exit(main())
