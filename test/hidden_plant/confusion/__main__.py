# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Run close_loop on every effect, size and noise, and write the page that says what came of it."""

import argparse
from collections.abc import Sequence
import os
from pathlib import Path
import sys

from tqdm import tqdm

from ..currents import KINDS
from ..declared import SPREADS
from ..effects import SIZES
from ..program import ROOT, RunError
from .cells import GROUPS, Cell, cells_of
from .figure import write_matrix
from .judging import OUTCOMES
from .page import page
from .running import Result, Results, line_of, run_cell, run_cells


def main(args: Sequence[str] | None = None) -> int:
    """Run the program; return its exit status."""
    options = _parser().parse_args(args)
    try:
        cells = cells_of(options.effects, options.sizes, options.noise, options.seed,
                         options.clean, options.kind, options.spread)
        options.out.mkdir(parents=True, exist_ok=True)
        results = Results(options.out / 'results.jsonl')
        failed = _run(cells, results, options)
        _write(results.of(cells), len(cells), options)
    except ValueError as error:
        print(f'confusion: {error}', file=sys.stderr)
        return 2
    except OSError as error:
        print(f'confusion: {error.filename}: {error.strerror}', file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print('confusion: interrupted; the same command goes on from here', file=sys.stderr)
        return 130
    print(f'{options.docs}: {len(cells) - failed} of {len(cells)} cells')
    return 1 if failed else 0


def _run(cells: list[Cell], results: Results, options: argparse.Namespace) -> int:
    with tqdm(total=len(cells), initial=len(results.of(cells)), unit='cell', disable=None) as bar:
        def tell(cell: Cell, ended: Result | RunError) -> None:
            bar.write(f'{cell.label}: {_words(ended)}')
            bar.update()

        return run_cells(cells, options.out, results, options.jobs, tell, run_cell)


def _words(ended: Result | RunError) -> str:
    if isinstance(ended, RunError):
        return f'FAILED: {ended}'
    said = ' + '.join(one.name for one in ended.found) or 'none'
    return f'{OUTCOMES[ended.judgement.outcome][0]} {said} ({ended.seconds:.0f} s)'


def _write(results: list[Result], planned: int, options: argparse.Namespace) -> None:
    figure = options.docs.parent / 'figures' / f'{options.docs.stem}.svg'
    write_matrix(results, figure)
    cells = options.docs.with_suffix('.jsonl')
    text = page(results, planned, _command(options), f'figures/{figure.name}', cells.name)
    _put(cells, ''.join(map(line_of, results)))
    _put(options.docs, text)


def _put(path: Path, text: str) -> None:
    unfinished = path.with_name(f'.{path.name}')
    unfinished.write_text(text, encoding='utf-8')
    os.replace(unfinished, path)


def _command(options: argparse.Namespace) -> str:
    """Return the command that makes the same results, whatever the folder."""
    listed = {'effects': options.effects, 'sizes': options.sizes,
              'noise': [f'{factor:g}' for factor in options.noise]}
    single = {name: getattr(options, name) for name in ('seed', 'clean', 'kind', 'spread')}
    words = [f'--{name} {",".join(values)}' for name, values in listed.items()]
    words += [f'--{name} {value}' for name, value in single.items()]
    return f'python -m hidden_plant.confusion --out FOLDER {" ".join(words)}'


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog='confusion', description=__doc__,
        epilog='Results stand in FOLDER/results.jsonl as soon as they are there: started again, '
        'an interrupted run goes on. Take a new FOLDER for changed code.')
    add = parser.add_argument
    add('--out', type=Path, required=True, metavar='FOLDER', help='records, reports and results')
    add('--effects', type=_words_of, default=['all'], metavar='A,B',
        help=f'effects, pairs a+b, or {", ".join(GROUPS)} (default: all, which has no pairs)')
    add('--sizes', type=_words_of, default=list(SIZES), metavar='A,B', help='default: all three')
    add('--noise', type=_numbers, default=[1.0, 3.0], metavar='A,B',
        help='factors on the noise (default: 1,3)')
    add('--clean', type=int, default=10, metavar='N',
        help='records without an effect at each noise (default: %(default)s)')
    add('--seed', type=int, default=1)
    add('--kind', choices=KINDS, default='mixed', help='test signal (default: %(default)s)')
    add('--spread', choices=SPREADS, default='samples',
        help='of the parameters (default: %(default)s)')
    add('--jobs', type=int, default=2, choices=range(1, 65), metavar='N',
        help='runs at a time (default: %(default)s)')
    add('--docs', type=Path, default=ROOT / 'docs' / 'confusion.md', metavar='PAGE',
        help='page to write, its cells beside it, its figure in the folder figures (default: in '
        'docs)')
    return parser


def _words_of(text: str) -> list[str]:
    return [word for word in text.split(',') if word]


def _numbers(text: str) -> list[float]:
    try:
        return [float(word) for word in _words_of(text)]
    except ValueError:
        raise argparse.ArgumentTypeError(f'{text!r} is not a list of numbers') from None


if __name__ == '__main__':
    sys.exit(main())
