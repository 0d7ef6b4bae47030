# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Diagnose all valves of a manifest, and say which need attention."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
import os
from pathlib import Path
import sys

from ..campaign.results import write_whole
from ..fleet.manifest import Valve, read_manifest
from ..fleet.outcome import ANSWERED, NAME, REFUSED, Outcome, line_of, read_outcomes
from ..fleet.running import run_fleet
from ..fleet.work import REPORTS, Order
from ..running.program import program_of, settings
from ..running.progress import Progress
from ..running.run_error import RunError
from .interruption import kept_interruption
from .number_arguments import count_of, seconds
from .path_argument import given_path

TIMEOUT = 3600.0
RATE = 0.05


def main(args: Sequence[str] | None = None) -> int:
    """Run the program; return its exit status."""
    options = _parser().parse_args(args)
    try:
        with kept_interruption() as check:
            _run(options, check)
    except RunError as error:
        print(f'fleet: {error}', file=sys.stderr)
        return 2
    except OSError as error:
        print(f'fleet: {error.filename}: {error.strerror}', file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print('fleet: interrupted; the same command goes on from here', file=sys.stderr)
        return 130
    return 0


def _run(options: argparse.Namespace, check: Callable[[], None]) -> None:
    valves = read_manifest(options.manifest)
    out = options.out.resolve()
    out.mkdir(parents=True, exist_ok=True)
    orders = _orders(options, valves, out)
    before = read_outcomes(out)
    done = {order.valve.name: before[order.valve.name] for order in orders
            if _is_done(before.get(order.valve.name), order)}
    write_whole(out / NAME, ''.join(map(line_of, done.values())))
    if done:
        print(f'{len(done)} of {len(valves)} valves have been diagnosed before', flush=True)
    left = [order for order in orders if order.valve.name not in done]
    tell = _Teller(out, done, len(left))
    try:
        run_fleet(left, options.scheduler, options.jobs, tell, check)
    finally:
        _write(out, [done[one.name] for one in valves if one.name in done], options.fdr,
               len(valves))


def _orders(options: argparse.Namespace, valves: Sequence[Valve], out: Path) -> list[Order]:
    folder = options.manifest.resolve().parent
    more = tuple(word for name in ('only', 'without') if getattr(options, name)
                 for word in (f'--{name}', *getattr(options, name)))
    program = program_of('', None)
    state, chosen = program.state(), settings(program.variables)
    return [Order(valve, folder, out, more, options.timeout, valve.digest(folder, more), state,
                  chosen) for valve in valves]


def _is_done(outcome: Outcome | None, order: Order) -> bool:
    """Tell whether a valve need not be diagnosed again: what failed is, as is what has changed."""
    if outcome is None or (outcome.inputs, outcome.state) != (order.inputs, order.state):
        return False
    report = order.out / REPORTS / order.valve.name / 'report.html'
    return outcome.ended == REFUSED or (outcome.ended == ANSWERED and report.exists())


class _Teller:
    """Keeps each outcome and says it, with the time to go."""

    def __init__(self, out: Path, done: dict[str, Outcome], count: int):
        self._out, self._done = out, done
        self._progress = Progress(count)

    def __call__(self, outcome: Outcome) -> None:
        """Keep an outcome and print it."""
        with (self._out / NAME).open('a', encoding='utf-8') as file:
            file.write(line_of(outcome))
        self._done[outcome.valve] = outcome
        what = ', '.join(outcome.effects) or outcome.message or outcome.kind
        print(self._progress.one_more(f'{outcome.valve}: {what}'), flush=True)


def _write(out: Path, outcomes: Sequence[Outcome], rate: float, planned: int) -> None:
    if not outcomes:
        return
    from ..fleet.table import PARQUET, counts, rows_of, write_tables

    rows = rows_of(outcomes, rate)
    written = write_tables(out, rows, rate, planned)
    print(', '.join(f'{number} {status}' for status, number in counts(rows).items()))
    if all(path.name != PARQUET for path in written):
        print(f'{PARQUET} was not written: it needs the Python package pyarrow', file=sys.stderr)
    print(', '.join(map(str, written)))


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog='fleet', description=__doc__,
        epilog='A manifest is a CSV with the columns valve, record, parameters, mapping, '
        'validation, validation_mapping; record and parameters are needed, paths count from its '
        'folder. Started again, it goes on: only valves whose files have changed, or all of them '
        'if the program has, are diagnosed again.')
    add = parser.add_argument
    add('manifest', type=given_path, metavar='MANIFEST.csv', help='a row for each valve')
    add('--out', type=given_path, required=True, metavar='DIR',
        help='folder for fleet.html, fleet.csv, fleet.parquet and a report for each valve')
    add('--scheduler', default='', metavar='tcp://HOST:8786',
        help='a Dask scheduler that runs already (default: this machine)')
    add('--jobs', type=count_of('diagnoses'), default=os.cpu_count() or 1, metavar='N',
        help='diagnoses at a time on this machine, where no scheduler is given (default: its '
        'cores)')
    add('--fdr', type=_share, default=RATE, metavar='Q',
        help='false-discovery rate over all valves (default: %(default)g)')
    add('--timeout', type=seconds, default=TIMEOUT, metavar='S',
        help='what takes longer counts as no answer, s (default: %(default)g)')
    among = parser.add_mutually_exclusive_group().add_argument
    among('--only', nargs='+', default=[], metavar='EFFECT', help='as of close_loop')
    among('--without', nargs='+', default=[], metavar='EFFECT', help='as of close_loop')
    return parser


def _share(text: str) -> float:
    try:
        share = float(text)
    except ValueError:
        share = 0.0
    if not 0.0 < share < 1.0:
        raise argparse.ArgumentTypeError(f'{text!r} is not a share between 0 and 1')
    return share


if __name__ == '__main__':
    sys.exit(main())
