# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Judge the diagnosis on sets of records whose truth is known, and compare two such campaigns."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path
import sys

from ..campaign.cases import CampaignError, Case, chosen, read_sets
from ..campaign.comparing import comparison
from ..campaign.page import html_page, markdown_text
from ..campaign.results import add_result, by_case, read_results, write_results, write_whole
from ..campaign.running import is_done, run_cases
from ..campaign.scoring import Outcome
from ..campaign.table import SET_HEAD, line_of, markdown, set_rows
from ..running.program import Program, program_of, settings
from ..running.progress import Progress
from ..running.run_error import RunError
from .interruption import kept_interruption
from .number_arguments import count_of, seconds
from .path_argument import given_path

TIMEOUT = 1200.0


def main(args: Sequence[str] | None = None) -> int:
    """Run the program; return its exit status."""
    options = _parser().parse_args(args)
    try:
        with kept_interruption() as check:
            options.run(options, check)
    except RunError as error:
        print(f'campaign: {error}', file=sys.stderr)
        return 2
    except OSError as error:
        print(f'campaign: {error.filename}: {error.strerror}', file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print('campaign: interrupted; the same command goes on from here', file=sys.stderr)
        return 130
    return 0


def _run(options: argparse.Namespace, check: Callable[[], None]) -> None:
    cases = chosen(read_sets(options.sets), options.case, options.quick)
    program = program_of(options.program, options.cwd)
    out = options.out.resolve()
    out.mkdir(parents=True, exist_ok=True)
    before = by_case(read_results(out))
    state = program.state()
    kept = {case.key: before[case.key] for case in cases if case.key in before
            and is_done(before[case.key], case.digest(), state, options.timeout)}
    asked = {case.key for case in cases}
    # what other sets came to with this program stays; what another program said goes
    others = [outcome for key, outcome in before.items()
              if key not in asked and outcome.state == state]
    outcomes = [*others, *kept.values()]
    write_results(out, outcomes)
    left = [case for case in cases if case.key not in kept]
    if kept:
        print(f'{len(kept)} of {len(cases)} cases have been run before', flush=True)
    tell = _Teller(out, outcomes, len(left))
    try:
        run_cases(left, program, out, options.timeout, options.scheduler, options.jobs, tell,
                  check)
    finally:
        _write(out, cases, program, outcomes)
    print(markdown(SET_HEAD, set_rows(_in_order(cases, outcomes))))
    print(f'{out / "table.md"}, {out / "page.html"}')


class _Teller:
    """Keeps each outcome and says it, with the time to go."""

    def __init__(self, out: Path, outcomes: list[Outcome], count: int):
        self._out, self._outcomes = out, outcomes
        self._progress = Progress(count)

    def __call__(self, outcome: Outcome) -> None:
        """Keep an outcome and print it."""
        add_result(self._out, outcome)
        self._outcomes.append(outcome)
        print(self._progress.one_more(line_of(outcome)), flush=True)


def _write(out: Path, cases: Sequence[Case], program: Program, outcomes: Sequence[Outcome]) -> None:
    """Write the tables of the cases that were asked for."""
    found = _in_order(cases, outcomes)
    if not found:
        return
    about = {
        'program': f'{" ".join(program.words)} in {program.folder}',
        'last commit': program.described() or 'not in a repository',
        'state': ', '.join(sorted({outcome.state for outcome in found})),
        'libraries': program.libraries,
        'settings': ', '.join(f'{n}={v}' for n, v in settings(program.variables).items()),
    }
    write_whole(out / 'table.md', markdown_text(found, len(cases), about))
    write_whole(out / 'page.html', html_page(found, len(cases), about))


def _in_order(cases: Sequence[Case], outcomes: Sequence[Outcome]) -> list[Outcome]:
    known = by_case(outcomes)
    return [known[case.key] for case in cases if case.key in known]


def _compare(options: argparse.Namespace, check: Callable[[], None]) -> None:
    found = []
    for folder in (options.first, options.second):
        outcomes = read_results(folder)
        if not outcomes:
            raise CampaignError(f'{folder}: there are no outcomes of a campaign')
        found.append(outcomes)
    names = [folder.resolve().name for folder in (options.first, options.second)]
    if names[0] == names[1]:
        names = [str(options.first), str(options.second)]
    text = comparison(found[0], found[1], (names[0], names[1]))
    check()
    if options.out:
        write_whole(options.out, text)
    print(text, end='')


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog='campaign', description=__doc__)
    actions = parser.add_subparsers(required=True, metavar='run | compare')
    run = actions.add_parser(
        'run', help='run close_loop on every case of some sets and score it',
        description='Run close_loop on every case of some sets and score what it says. DIR gets '
        'cases.jsonl, table.md, page.html and the reports. Started again, it goes on: only cases '
        'whose files have changed, or all of them if the program has, are run again.')
    add = run.add_argument
    add('sets', nargs='+', type=given_path, metavar='SET',
        help='folder with CASE.yaml, CASE_fit.csv, CASE_val.csv and key.json')
    add('--out', type=given_path, required=True, metavar='DIR', help='folder of the campaign')
    add('--scheduler', default='', metavar='tcp://HOST:8786',
        help='a Dask scheduler that runs already (default: this machine)')
    add('--jobs', type=count_of('runs'), default=2, metavar='N',
        help='runs at a time on this machine, where no scheduler is given (default: 2)')
    add('--quick', action='store_true', help='60 cases at the most, spread evenly over all')
    add('--case', nargs='+', default=[], metavar='PATTERN',
        help="only cases of such names, e.g. '*friction*'")
    add('--timeout', type=seconds, default=TIMEOUT, metavar='S',
        help='what takes longer counts as no answer, s (default: %(default)g)')
    add('--program', default='', metavar='"PYTHON -m booster_ros"',
        help='the program to judge (default: this one)')
    add('--cwd', type=given_path, metavar='FOLDER',
        help='folder in which it runs, the root of another checkout (default: the current one)')
    run.set_defaults(run=_run)
    compare = actions.add_parser(
        'compare', help='compare two campaigns over the same cases',
        description='Compare two campaigns case by case.')
    compare.add_argument('first', type=given_path, metavar='A', help='folder of a campaign')
    compare.add_argument('second', type=given_path, metavar='B', help='folder of another one')
    compare.add_argument('--out', type=given_path, metavar='FILE', help='write the text there too')
    compare.set_defaults(run=_compare)
    return parser


if __name__ == '__main__':
    sys.exit(main())
