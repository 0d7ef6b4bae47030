# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Score close_loop on a folder of records with hidden effects, as `python -m hidden_plant` writes it.

Of each CASE in key.json close_loop is shown CASE_fit.csv and CASE.yaml; how well the model that it
writes meets CASE_val.csv, from its first row on, is told by `simulate`. One at a time.
"""

import argparse
from collections.abc import Iterator, Sequence
import json
from pathlib import Path
import statistics
import sys
from tempfile import TemporaryDirectory
import time
from typing import NamedTuple

import numpy as np

from .program import RunError, run_program
from .sensors import POSITION_NOISE, PRESSURE_NOISE

NOISE = {'chamber_pressure': PRESSURE_NOISE, 'valve_position': POSITION_NOISE}
NEAR = 1.5
"""Up to so many times the noise, in pressure and in position, a record counts as met."""


class Score(NamedTuple):
    """What was said of a case, whether name and place are right, errors over noise, seconds."""

    case: str
    hidden: str
    said: str
    named: bool
    placed: bool
    before: tuple[float, ...]
    after: tuple[float, ...]
    seconds: float

    @property
    def near(self) -> bool:
        """Whether the other record is met to NEAR times its noise."""
        return max(self.after) < NEAR


def main(args: Sequence[str] | None = None) -> int:
    """Run the program; return its exit status: 2 where the folder or a run of a case fails."""
    parser = argparse.ArgumentParser(prog='scoring', description=__doc__)
    parser.add_argument('folder', type=Path)
    parser.add_argument('cases', nargs='*', help='default: all of key.json')
    options = parser.parse_args(args)
    scores = []
    try:
        for score in scored(options.folder, options.cases):
            print(line_of(score), flush=True)
            scores.append(score)
        print(summary_of(scores))
    except (OSError, ValueError, KeyError, RunError) as error:
        print(f'scoring: {error}', file=sys.stderr)
        return 2
    return 0


def scored(folder: Path, cases: Sequence[str] = ()) -> Iterator[Score]:
    """Yield the score of each case; RunError where a program fails on one."""
    key = json.loads((folder / 'key.json').read_text(encoding='utf-8'))
    for case in cases or sorted(key):
        yield _score(folder.resolve(), case, key[case])


def _score(folder: Path, case: str, hidden: dict) -> Score:
    with TemporaryDirectory() as out:
        started = time.monotonic()
        run_program('close_loop', '--record', folder / f'{case}_fit.csv',
                    '--params', folder / f'{case}.yaml', '--out', out)
        seconds = time.monotonic() - started
        report = json.loads((Path(out) / 'report.json').read_text(encoding='utf-8'))
        other = folder / f'{case}_val.csv'
        before, after = (_missed(Path(out) / name, other)
                         for name in ('positioner_before.yaml', 'positioner.yaml'))
    effects = report['effects']
    said = '+'.join(effect['name'] for effect in effects) or report['verdict']
    return Score(case, ' or '.join(hidden['names']), said,
                 is_named(hidden['names'], report['verdict'], effects),
                 is_placed(hidden['location'], effects), before, after, seconds)


def is_named(names: Sequence[str], verdict: str, effects: Sequence[dict]) -> bool:
    """
    Tell whether what was found has the right name, or one that it is not told apart from.

    `names` are those that count as right; one with '+' asks for both, 'none' for nothing, and
    'unknown' is right where nothing but that was found.
    """
    if names[0] == 'none':
        return not effects
    group = {name for effect in effects for name in (effect['name'], *effect['confused_with'])}
    if '+' in names[0]:
        return set(names[0].split('+')) <= group
    return bool(set(names) & group) or ('unknown' in names and verdict == 'unknown')


def is_placed(location: str, effects: Sequence[dict]) -> bool:
    """Tell whether something was found wherever something is hidden, 'a+b' for two places."""
    if location == 'none':
        return not effects
    return set(location.split('+')) <= {effect['location'] for effect in effects}


def line_of(score: Score) -> str:
    """Return a score as a line of text."""
    before, after = ('/'.join(f'{ratio:.2f}' for ratio in each)
                     for each in (score.before, score.after))
    return (f'{score.case}: {score.hidden}; said {score.said}: '
            f'name {"right" if score.named else "WRONG"}, '
            f'place {"right" if score.placed else "WRONG"}; '
            f'other record {before} -> {after} x noise; {score.seconds:.0f} s')


def summary_of(scores: Sequence[Score]) -> str:
    """Return what comes of all of them; ValueError if there are none."""
    if not scores:
        raise ValueError('key.json has no cases')
    clean = [score for score in scores if score.hidden == 'none']
    return (f'{len(scores)} records: name {sum(s.named for s in scores)}, '
            f'place {sum(s.placed for s in scores)}, '
            f'{sum(s.named for s in clean)} of {len(clean)} clean ones left alone, '
            f'{sum(s.near for s in scores)} within {NEAR:g} x noise, '
            f'{statistics.median(s.seconds for s in scores):.0f} s (median), '
            f'{max(s.seconds for s in scores):.0f} s at the most')


def _missed(parameters: Path, record: Path) -> tuple[float, ...]:
    """Return the root mean square error of each channel on a record, over its noise."""
    out = parameters.parent / 'simulated.csv'
    run_program('simulate', '--params', parameters, '--input', record, '--out', out)
    simulated, measured = (np.genfromtxt(path, delimiter=',', names=True)
                           for path in (out, record))
    out.unlink()
    return tuple(float(np.sqrt(np.mean((simulated[name] - measured[name])**2))) / noise
                 for name, noise in NOISE.items())


if __name__ == '__main__':
    sys.exit(main())
