# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Running cells: records, close_loop, and a line of results for each as soon as it is there."""

from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
import json
from pathlib import Path
import re
from threading import Lock
import time

import numpy as np

from ..cases import write_case
from ..program import ROOT, RunError, run_program
from .cells import Cell, values_of
from .judging import Found, Judgement, judge


@dataclass(frozen=True)
class Result:
    """
    What close_loop said of a cell.

    `before` and `after` are errors on the validation record as multiples of the noise, root mean
    square over its channels; `seconds` is how long the program took, `decision` the last one of
    docs/decisions.md when it ran.
    """

    cell: Cell
    found: tuple[Found, ...]
    before: float
    after: float
    seconds: float
    decision: int

    @property
    def judgement(self) -> Judgement:
        """How that suits what was hidden."""
        return judge(self.cell.keys, self.found)


class Results:
    """
    A file of results, a line of JSON each; what was interrupted goes on from it.

    ValueError where the file holds something else.
    """

    def __init__(self, path: Path):
        self._path = path
        self._lock = Lock()
        text = path.read_text(encoding='utf-8') if path.exists() else ''
        whole = text[:text.rfind('\n') + 1]
        if whole != text:  # a last line that was never finished
            path.write_text(whole, encoding='utf-8')
        try:
            self._results = [_result(json.loads(line)) for line in whole.splitlines()]
        except (KeyError, TypeError, ValueError):
            raise ValueError(f'{path}: is not a file of results') from None

    def of(self, cells: Iterable[Cell]) -> list[Result]:
        """Return what is known of these cells, in their order."""
        known = {result.cell: result for result in self._results}
        return [known[cell] for cell in cells if cell in known]

    def add(self, result: Result) -> None:
        """Append a result to the file at once."""
        with self._lock, self._path.open('a', encoding='utf-8') as file:
            file.write(line_of(result))
            self._results.append(result)


def line_of(result: Result) -> str:
    """Return a result as a line of a file of results."""
    return json.dumps(_values(result)) + '\n'


def run_cells(
    cells: Sequence[Cell], folder: Path, results: Results, jobs: int,
    tell: Callable[[Cell, Result | RunError], None], run: Callable[[Cell, Path], Result],
) -> int:
    """
    Run the cells of which nothing is known, `jobs` at a time; return how many failed.

    `tell` hears of each when it has ended. An interruption lets the running ones end.
    """
    known = {result.cell for result in results.of(cells)}
    failed = 0

    def one(cell: Cell) -> Result:
        result = run(cell, folder)
        results.add(result)
        return result

    with ThreadPoolExecutor(jobs) as pool:
        waiting = {pool.submit(one, cell): cell for cell in cells if cell not in known}
        try:
            for future in as_completed(waiting):
                try:
                    tell(waiting[future], future.result())
                except RunError as error:
                    failed += 1
                    tell(waiting[future], error)
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise
    return failed


def run_cell(cell: Cell, folder: Path) -> Result:
    """Write the cell's records into the folder, run close_loop on them; RunError if that fails."""
    case = cell.case()
    write_case(case, folder)
    records = folder.resolve() / case.name
    out = folder.resolve() / f'{case.name}_out'
    started = time.monotonic()
    run_program('close_loop', '--record', f'{records}_fit.csv', '--params', f'{records}.yaml',
                '--validation', f'{records}_val.csv', '--out', out)
    seconds = time.monotonic() - started
    report = json.loads((out / 'report.json').read_text(encoding='utf-8'))
    return Result(cell, tuple(
        Found(e['name'], e['location'], tuple(e['confused_with'])) for e in report['effects']),
        _error(report, 'before'), _error(report, 'after'), seconds,
        last_decision((ROOT / 'docs' / 'decisions.md').read_text(encoding='utf-8')))


def last_decision(text: str) -> int:
    """Return the number of the last decision on the page of decisions; ValueError if none."""
    return max(int(number) for number in re.findall(r'^\*\*([0-9]+)\. ', text, re.MULTILINE))


def _error(report: dict, stage: str) -> float:
    ratios = [channel[stage] / channel['noise'] for channel in report['validation'].values()]
    return float(np.sqrt(np.mean(np.square(ratios))))


def _values(result: Result) -> dict:
    return {**values_of(result.cell), 'found': [one._asdict() for one in result.found],
            'before': result.before, 'after': result.after, 'seconds': result.seconds,
            'decision': result.decision}


def _result(values: dict) -> Result:
    found = tuple(Found(one['name'], one['location'], tuple(one['confused_with']))
                  for one in values.pop('found'))
    before, after, seconds = (float(values.pop(key)) for key in ('before', 'after', 'seconds'))
    decision = int(values.pop('decision'))
    return Result(Cell(**values), found, before, after, seconds, decision)
