# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The page: results in tables, as Markdown."""

from collections import Counter
from collections.abc import Iterable, Sequence
import statistics
import textwrap

from scipy.stats import binomtest

from ..effects import EFFECTS, NAMELESS
from .cells import NO_SIZE
from .judging import OUTCOMES
from .running import Result

_ABOUT = """
A plant that was written apart from the model (`test/hidden_plant`) plays valves with one effect
each, two where a row names two, or none; `close_loop` is shown 150 s of current, chamber pressure
and valve position, and 90 s more for validation. Small, medium and large effects move the record,
before anything is refitted, by 2, 10 and 36 times noise 1 (150 Pa and 8 µm RMS) in the median of
the named ones. What looks like a declared parameter that is off is larger (the bench set by up to
119), as a refit explains much of it: what that leaves stands in every cell.
`test/hidden_plant/effects.py` has the sizes in SI units. Effects that a record hardly shows are not
left out: not to see one counts as a miss.
"""


def page(results: Sequence[Result], planned: int, command: str, figure: str, cells: str) -> str:
    """
    Return the page on these results, of which `planned` should be there.

    `command` made them; `figure` and `cells` are where the page finds the matrix of names, and the
    results themselves.
    """
    missing = planned - len(results)
    parts = [
        '# What `close_loop` says of what is hidden',
        textwrap.fill(_ABOUT.strip(), 120),
        f'Made, from the folder `test`, by\n\n```\n{command}\n```\n\n'
        f'What each cell came to is in [{cells}]({cells}); with that as `FOLDER/results.jsonl` the '
        'command goes on from there, as long as the diagnosis is the same.',
        _states(results),
        f'**{missing} of {planned} runs are missing.**' if missing else '',
        '## In short', _shares(results), _seconds(results),
        '## Every cell', _legend(), _cells(results),
        '## What is taken for what',
        f'![Hidden effects against what was named]({figure})', _mistaken(results),
        '## Clean records', _clean(results),
    ]
    return '\n\n'.join(filter(None, parts)) + '\n'


def _states(results: Sequence[Result]) -> str:
    """Return on which states of the diagnosis the cells were run."""
    if not results:
        return ''
    newest = max(result.decision for result in results)
    parts: Counter[tuple[int, float, str]] = Counter(
        (result.decision, result.cell.noise, result.cell.size) for result in results)
    told = {
        decision: ', '.join(
            f'{count} {"clean" if size == NO_SIZE else size} at noise {noise:g}'
            for (state, noise, size), count in parts.items() if state == decision)
        for decision in sorted({state for state, _, _ in parts}, reverse=True)}
    if len(told) == 1:
        return f'All were run on the state of [decision {newest}](decisions.md).'
    return ('Not all were run on the same state of the diagnosis: ' + '; '.join(
        f'on that of [decision {state}](decisions.md) {cells}' for state, cells in told.items())
        + '.')


def share(hits: int, of: int) -> str:
    """Return 'hits/of (share, 95 % interval)', Wilson's interval."""
    if not of:
        return ''
    interval = binomtest(hits, of).proportion_ci(0.95, 'wilson')
    return (f'{hits}/{of} = {100 * hits / of:.0f} % '
            f'({100 * interval.low:.0f} to {100 * interval.high:.0f})')


def kind_of(result: Result) -> str:
    """Return what sort of cell it is: clean, catalogued, without a name, or several effects."""
    keys = result.cell.keys
    if not keys:
        return 'clean'
    if len(keys) > 1:
        return 'several effects'
    return 'no name in the catalogue' if keys[0] in NAMELESS else 'one effect'


def _shares(results: Sequence[Result]) -> str:
    rows = []
    for kind in ('one effect', 'several effects', 'no name in the catalogue'):
        those = [r for r in results if kind_of(r) == kind]
        for size, noise in _columns(those):
            part = [r for r in those if (r.cell.size, r.cell.noise) == (size, noise)]
            outcomes = Counter(r.judgement.outcome for r in part)
            right, group = outcomes['right'], outcomes['group']
            rows.append([
                kind, size, f'{noise:g}', share(right, len(part)),
                share(right + group, len(part)),
                share(sum(r.judgement.placed for r in part), len(part))])
    if not rows:
        return ''
    return 'Shares with 95 % intervals (Wilson).\n\n' + _table(
        ['hidden', 'size', 'noise', 'right (●)', 'right or in its group (● ◐)', 'right place'],
        rows)


def _seconds(results: Sequence[Result]) -> str:
    if not results:
        return ''
    seconds = [r.seconds for r in results]
    return (f'A run took {statistics.median(seconds):.0f} s (median), {max(seconds):.0f} s at the '
            'most, with others beside it.')


def _legend() -> str:
    meanings = '\n'.join(f'- {symbol} {meaning}' for symbol, meaning in OUTCOMES.values())
    return (f'{meanings}\n\nBehind the symbol: error on the validation record, refitted without '
            'the effect → with it, in multiples of the noise (1 is as good as can be).')


def _cells(results: Sequence[Result]) -> str:
    hidden = [r for r in results if r.cell.keys]
    columns = _columns(hidden)
    if not columns:
        return ''
    rows = []
    for effect in dict.fromkeys(r.cell.effect for r in _in_order(hidden)):
        cells = {(r.cell.size, r.cell.noise): _cell(r) for r in hidden if r.cell.effect == effect}
        rows.append([f'`{effect}`', *(cells.get(column, '') for column in columns)])
    return _table(['hidden', *(f'{size}, noise {noise:g}' for size, noise in columns)], rows)


def _cell(result: Result) -> str:
    symbol = OUTCOMES[result.judgement.outcome][0]
    return f'{symbol} {_multiple(result.before)} → {_multiple(result.after)}'


def _multiple(ratio: float) -> str:
    return f'{ratio:.2f}' if ratio < 10 else f'{ratio:.0f}'


def _mistaken(results: Sequence[Result]) -> str:
    counts: Counter[tuple[str, str]] = Counter()
    for result in results:
        if result.cell.keys and result.judgement.outcome != 'right':
            said = ' + '.join(one.name for one in result.found) or 'none'
            counts[result.cell.effect, said] += 1
    if not counts:
        return 'Nothing was taken for anything else.'
    order = sorted(counts.items(), key=lambda item: (-item[1], item[0]))
    return _table(['hidden', 'said', 'times'],
                  [[f'`{effect}`', f'`{said}`', str(times)] for (effect, said), times in order])


def _clean(results: Sequence[Result]) -> str:
    clean = [r for r in results if not r.cell.keys]
    rows = []
    for noise in dict.fromkeys(r.cell.noise for r in clean):
        part = [r for r in clean if r.cell.noise == noise]
        added = [' + '.join(one.name for one in r.found) for r in part if r.found]
        rows.append([f'{noise:g}', share(len(added), len(part)),
                     ', '.join(f'`{name}`' for name in added)])
    return _table(['noise', 'something added', 'what'], rows) if rows else ''


def _columns(results: Iterable[Result]) -> list[tuple[str, float]]:
    """Return the pairs of size and noise, small ones and quiet ones first."""
    order = ('small', 'medium', 'large', NO_SIZE)
    return sorted({(r.cell.size, r.cell.noise) for r in results},
                  key=lambda column: (column[1], order.index(column[0])))


def _in_order(results: Iterable[Result]) -> list[Result]:
    order = list(EFFECTS)
    return sorted(results, key=lambda r: (len(r.cell.keys), [order.index(k) for k in r.cell.keys]))


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [head, ['---'] * len(head), *rows]
    return '\n'.join(f'| {" | ".join(line)} |' for line in lines)


def actual_of(result: Result) -> str:
    """Return the row of the matrix a single cell belongs to: catalogue name, structure, none."""
    if not result.cell.keys:
        return 'none'
    key = result.cell.keys[0]
    return key if key in NAMELESS else EFFECTS[key].names[0]
