# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Fit drawn valves of which all is known, and write the page on how far intervals hold it."""

import argparse
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
import sys

from hidden_plant.program import ROOT
from tqdm import tqdm

from .fits import intervals, levels
from .page import page
from .valves import SIZES, Drawn

COLOURS = (0.0, 0.9)
ALL_COLOURS = (0.0, 0.5, 0.8, 0.9, 0.95)
KINDS = ('stairs', 'sines', 'hops')


def main(args: Sequence[str] | None = None) -> int:
    """Run the program; return its exit status."""
    options = _parser().parse_args(args)
    if not options.docs.parent.is_dir():
        print(f'interval_coverage: --docs: there is no folder {options.docs.parent}',
              file=sys.stderr)
        return 2
    if min(options.records, options.levels, options.jobs) < 1:
        print('interval_coverage: --records, --levels and --jobs must be 1 or more',
              file=sys.stderr)
        return 2
    cells = [(effect, carried) for effect in options.effects for carried in COLOURS]
    noises = [(kind, carried) for kind in KINDS for carried in ALL_COLOURS]
    fitted = [Drawn(effect, carried, options.seed + seed)
              for effect, carried in cells for seed in range(options.records)]
    heard = [Drawn('', carried, options.seed + seed, kind)
             for kind, carried in noises for seed in range(options.levels)]
    with ProcessPoolExecutor(options.jobs) as pool:
        held = list(tqdm(pool.map(intervals, fitted), total=len(fitted), unit='fit', disable=None))
        found = list(tqdm(pool.map(levels, heard), total=len(heard), unit='record', disable=None))
    text = page(
        {cell: held[k * options.records:(k + 1) * options.records]
         for k, cell in enumerate(cells)},
        {noise: [level for pair in found[k * options.levels:(k + 1) * options.levels]
                 for level in pair] for k, noise in enumerate(noises)},
        _command(options))
    try:
        options.docs.write_text(text, encoding='utf-8')
    except OSError as error:
        print(f'interval_coverage: {error.filename}: {error.strerror}', file=sys.stderr)
        return 2
    print(options.docs)
    return 0


def _command(options: argparse.Namespace) -> str:
    chosen = '' if options.effects == ['', *SIZES] else (
        f' --effects {",".join(effect or "none" for effect in options.effects)}')
    return (f'python -m interval_coverage --records {options.records} --levels {options.levels} '
            f'--seed {options.seed}{chosen}')


def _effects(text: str) -> list[str]:
    names = ['' if name == 'none' else name for name in text.split(',')]
    for name in names:
        if name and name not in SIZES:
            raise argparse.ArgumentTypeError(
                f'{name} is none of {", ".join(["none", *SIZES])}')
    return names


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog='interval_coverage', description=__doc__)
    parser.add_argument('--records', type=int, default=10, help='fits of each effect and colour')
    parser.add_argument('--levels', type=int, default=40, help='of each current and colour')
    parser.add_argument('--seed', type=int, default=1)
    parser.add_argument('--effects', type=_effects, default=['', *SIZES],
                        help='comma-separated (default: all that can be compared)')
    parser.add_argument('--jobs', type=int, default=2, help='at once')
    parser.add_argument('--docs', type=Path, default=ROOT / 'docs/coverage.md')
    return parser


if __name__ == '__main__':
    sys.exit(main())
