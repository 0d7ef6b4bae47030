# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A campaign in rows of text: one for each set, one for each case."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
import statistics

from .scoring import NEAR, Interval, Outcome

SET_HEAD = (
    'set', 'records', 'answered', 'right name', 'right place', 'clean ones left alone',
    f'second record within {NEAR:g} × noise', 'sizes held', 'declared parameters held',
    'largest error, interval widths', 'wrong but confirmed', 'median, s', 'longest, s',
    'CPU, median, s')

CASE_HEAD = (
    'set', 'case', 'hidden', 'said', 'standing', 'explained', 'name', 'place',
    'second record before, × noise', 'after, × noise', 'held-out part, × noise', 'sizes held',
    'largest error, interval widths', 's', 'CPU, s', 'remark')

NONE = '–'


def set_rows(outcomes: Sequence[Outcome]) -> list[tuple[str, ...]]:
    """Return a row for each set, and one for all if there are several."""
    names = list(dict.fromkeys(outcome.set for outcome in outcomes))
    rows = [_set_row(name, [o for o in outcomes if o.set == name]) for name in names]
    return rows if len(names) == 1 else [*rows, _set_row('all', outcomes)]


def _set_row(name: str, outcomes: Sequence[Outcome]) -> tuple[str, ...]:
    clean = [o for o in outcomes if o.truth.is_clean]
    judged = [o.near for o in outcomes if o.near is not None]
    seconds = [o.seconds for o in outcomes]
    intervals = [interval for o in outcomes for interval in o.intervals]
    sizes = [interval for interval in intervals if interval.of_effect]
    others = [interval for interval in intervals if not interval.of_effect]
    confirmed = [n for o in outcomes for n in o.wrongly_confirmed]
    graded = any('standing' in effect for o in outcomes for effect in o.found)
    return (
        name, str(len(outcomes)), str(sum(o.answered for o in outcomes)),
        share(o.named for o in outcomes), share(o.placed for o in outcomes),
        share(o.named for o in clean), share(judged),
        share(interval.holds for interval in sizes), share(interval.holds for interval in others),
        _widest(sizes), str(len(confirmed)) if graded else NONE,
        f'{statistics.median(seconds):.0f}', f'{max(seconds):.0f}',
        f'{statistics.median(o.cpu_seconds for o in outcomes):.0f}')


def share(flags: Iterable[bool | None]) -> str:
    """Return how many of them are true, of how many."""
    listed = list(flags)
    return f'{sum(map(bool, listed))} of {len(listed)}' if listed else NONE


def case_rows(outcomes: Sequence[Outcome]) -> list[tuple[str, ...]]:
    """Return a row for each case."""
    return [_case_row(outcome) for outcome in outcomes]


def _case_row(outcome: Outcome) -> tuple[str, ...]:
    sizes = [interval for interval in outcome.intervals if interval.of_effect]
    remarks = [outcome.message] if outcome.message else []
    remarks += [f'{name}: wrong but confirmed' for name in outcome.wrongly_confirmed]
    return (
        outcome.set, outcome.case, ' or '.join(outcome.truth.names), outcome.said,
        _each(outcome.found, 'standing', str), _each(outcome.found, 'explained', '{:.2f}'.format),
        'right' if outcome.named else 'WRONG', 'right' if outcome.placed else 'WRONG',
        _ratio(outcome.over_noise(outcome.before)), _ratio(outcome.over_noise(outcome.after)),
        _ratio(outcome.held_out), share(interval.holds for interval in sizes), _widest(sizes),
        f'{outcome.seconds:.0f}', f'{outcome.cpu_seconds:.0f}', '; '.join(remarks))


def _each(effects: Sequence[Mapping[str, object]], key: str, form: Callable[..., str]) -> str:
    texts = [NONE if effect.get(key) is None else form(effect[key]) for effect in effects]
    return '+'.join(texts) if any(text != NONE for text in texts) else NONE


def _widest(intervals: Sequence[Interval]) -> str:
    return f'{max(i.widths for i in intervals):.2g}' if intervals else NONE


def _ratio(ratio: float | None) -> str:
    return NONE if ratio is None else f'{ratio:.2f}'


def line_of(outcome: Outcome) -> str:
    """Return an outcome as a line on the terminal."""
    if not outcome.answered:
        return f'{outcome.set}/{outcome.case}: NO ANSWER: {outcome.message}'
    before, after = (_ratio(outcome.over_noise(errors))
                     for errors in (outcome.before, outcome.after))
    return (f'{outcome.set}/{outcome.case}: {" or ".join(outcome.truth.names)}; '
            f'said {outcome.said}: name {"right" if outcome.named else "WRONG"}, '
            f'place {"right" if outcome.placed else "WRONG"}; '
            f'second record {before} -> {after} x noise; {outcome.seconds:.0f} s')


def markdown(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table as Markdown."""
    lines = [head, ['---'] * len(head), *rows]
    return '\n'.join(f'| {" | ".join(cell.replace("|", chr(92) + "|") for cell in line)} |'
                     for line in lines)
