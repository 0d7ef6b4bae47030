# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Two campaigns over the same cases, case by case."""

from __future__ import annotations

from collections.abc import Callable, Sequence
import math
from typing import NamedTuple

import numpy as np

from .cases import CampaignError
from .results import by_case
from .scoring import NEAR, Outcome
from .table import NONE, markdown, share

SAME_SIZE = 0.1
"""Up to such a share of its interval, a size counts as the same."""

Pair = tuple[Outcome, Outcome]


class Mcnemar(NamedTuple):
    """Cases that are right in one of two campaigns only, and how likely chance makes that."""

    only_first: int
    only_second: int
    p: float


class Moved(NamedTuple):
    """The largest change of a size between two answers, in widths of its interval in the first."""

    widths: float
    parameter: str


def mcnemar(first: Sequence[bool], second: Sequence[bool]) -> Mcnemar:
    """
    Return McNemar's exact test of paired answers.

    Where the two differ, either is as likely to be the right one if they are equally good: the p
    value is two-sided, of a binomial distribution with n = b + c and probability 1/2. Source:
    Q. McNemar, Psychometrika 12 (1947) 153.
    """
    from scipy.stats import binomtest  # takes a second to import

    b = sum(one and not other for one, other in zip(first, second, strict=True))
    c = sum(other and not one for one, other in zip(first, second, strict=True))
    return Mcnemar(b, c, float(binomtest(b, b + c).pvalue) if b + c else 1.0)


def paired(first: Sequence[Outcome], second: Sequence[Outcome]) -> list[Pair]:
    """
    Return the cases that both campaigns have, by set and name.

    If the sets have other names (a set and the same set disturbed), the names of cases alone tell
    them. CampaignError where nothing is common.
    """
    one, other = by_case(first), by_case(second)
    pairs = [(one[key], other[key]) for key in one if key in other]
    if not pairs:
        by_name = [{outcome.case: outcome for outcome in each} for each in (first, second)]
        if all(len(names) == len(each)
               for names, each in zip(by_name, (one, other), strict=True)):
            pairs = [(by_name[0][name], by_name[1][name])
                     for name in by_name[0] if name in by_name[1]]
    if not pairs:
        raise CampaignError('the two campaigns have no case in common')
    return pairs


def error_ratio(first: Outcome, second: Outcome) -> float | None:
    """Return the error of `second` on the second record over that of `first`, a geometric mean."""
    if not first.after or not second.after:
        return None
    logs = [math.log(second.after[name] / error) for name, error in first.after.items()
            if error > 0.0 and second.after.get(name, 0.0) > 0.0]
    return math.exp(sum(logs) / len(logs)) if logs else None


def same_answer(first: Outcome, second: Outcome) -> bool:
    """Tell whether both gave one verdict and the same names, in whatever order."""
    return first.answered and second.answered and first.verdict == second.verdict and sorted(
        effect['name'] for effect in first.found) == sorted(
        effect['name'] for effect in second.found)


def most_moved(first: Outcome, second: Outcome) -> Moved:
    """Return the largest change of a size that both have, relative to its interval in `first`."""
    sizes = {name: estimate for effect in second.found
             for name, estimate in effect['parameters'].items()}
    moved = [Moved(0.0, '')]
    for effect in first.found:
        for name, estimate in effect['parameters'].items():
            ends = [estimate['value'], estimate['low'], estimate['high'],
                    sizes.get(name, {}).get('value')]
            if any(end is None for end in ends) or ends[0] == ends[3]:
                continue
            change = abs(ends[3] - ends[0])
            moved.append(Moved(change / max(ends[2] - ends[1], 1e-12 * change), name))
    return max(moved)


def comparison(first: Sequence[Outcome], second: Sequence[Outcome], names: tuple[str, str]) -> str:
    """Return the comparison as Markdown; `names` are those of the campaigns."""
    pairs = paired(first, second)
    count = f'{len(pairs)} cases are in both'
    for name, outcomes in zip(names, (first, second), strict=True):
        if len(outcomes) > len(pairs):
            count += f'; {len(outcomes) - len(pairs)} in {name} only'
    return '\n\n'.join([
        f'# {names[0]} and {names[1]}', f'{count}.',
        markdown(('right', *names, f'only {names[0]}', f'only {names[1]}', 'p (McNemar)'),
                 _tests(pairs)),
        markdown(('', *names), _levels(pairs)),
        _ratios(pairs, names), _agreement(pairs), _differences(pairs, names)]) + '\n'


def _tests(pairs: Sequence[Pair]) -> list[tuple[str, ...]]:
    judged: dict[str, tuple[Callable[[Outcome], bool | None], Sequence[Pair]]] = {
        'name': (lambda o: o.named, pairs),
        'place': (lambda o: o.placed, pairs),
        'clean ones left alone': (lambda o: o.named, [p for p in pairs if p[0].truth.is_clean]),
        f'second record within {NEAR:g} × noise': (
            lambda o: o.near, [p for p in pairs if p[0].near is not None]),
    }
    rows: list[tuple[str, ...]] = []
    for title, (right, some) in judged.items():
        one, other = ([bool(right(pair[k])) for pair in some] for k in (0, 1))
        test = mcnemar(one, other)
        rows.append((title, share(one), share(other), str(test.only_first),
                     str(test.only_second), f'{test.p:.3g}'))
    return rows


def _levels(pairs: Sequence[Pair]) -> list[tuple[str, ...]]:
    """Return what each has by itself: answers, coverage and time."""
    def row(title: str, of: Callable[[Sequence[Outcome]], str]) -> tuple[str, ...]:
        return title, *(of([pair[k] for pair in pairs]) for k in (0, 1))

    def held(of_effect: bool) -> Callable[[Sequence[Outcome]], str]:
        return lambda outcomes: share(
            i.holds for o in outcomes for i in o.intervals if i.of_effect is of_effect)

    def widest(outcomes: Sequence[Outcome]) -> str:
        widths = [i.widths for o in outcomes for i in o.intervals if i.of_effect]
        return f'{max(widths):.2g}' if widths else NONE

    return [
        row('answered', lambda outcomes: share(o.answered for o in outcomes)),
        row('95 % intervals of sizes that hold the truth', held(True)),
        row('95 % intervals of declared parameters that hold the truth', held(False)),
        row('largest error of a size, interval widths', widest),
        row('wrong but confirmed', lambda outcomes: str(
            sum(len(o.wrongly_confirmed) for o in outcomes))),
        row('time, median, s', lambda outcomes: f'{np.median([o.seconds for o in outcomes]):.1f}'),
        row('time, longest, s', lambda outcomes: f'{max(o.seconds for o in outcomes):.1f}'),
        row('time, sum, s', lambda outcomes: f'{sum(o.seconds for o in outcomes):.0f}'),
        row('CPU, sum, s', lambda outcomes: f'{sum(o.cpu_seconds for o in outcomes):.0f}'),
    ]


def _ratios(pairs: Sequence[Pair], names: tuple[str, str]) -> str:
    found = {
        'Error on the second record': [r for p in pairs if (r := error_ratio(*p)) is not None],
        'Time': [p[1].seconds / p[0].seconds for p in pairs
                 if p[0].answered and p[1].answered and p[0].seconds > 0.0],
        'CPU time': [p[1].cpu_seconds / p[0].cpu_seconds for p in pairs
                     if p[0].answered and p[1].answered and p[0].cpu_seconds > 0.0]}
    lines = []
    for title, ratios in found.items():
        low, middle, high = np.quantile(ratios, [0.25, 0.5, 0.75]) if ratios else [math.nan] * 3
        lines.append(f'- {title}, {names[1]} over {names[0]}: median {middle:.3f}, '
                     f'quartiles {low:.3f} and {high:.3f} ({len(ratios)} cases)')
    return '\n'.join(lines)


def _agreement(pairs: Sequence[Pair]) -> str:
    same = [pair for pair in pairs if same_answer(*pair)]
    moved = [(most_moved(*pair), pair[0]) for pair in same]
    still = sum(each.widths <= SAME_SIZE for each, _ in moved)
    text = (f'Same verdict and names: {share(same_answer(*pair) for pair in pairs)} '
            f'({100.0 * len(same) / len(pairs):.1f} %); of these, all sizes within '
            f'{SAME_SIZE:g} of their interval: {still} of {len(same)}.')
    if not moved:
        return text
    largest, outcome = max(moved, key=lambda each: each[0].widths)
    if not largest.parameter:
        return f'{text} No size differs.'
    return (f'{text} Largest change of a size: {largest.widths:.2g} interval widths, '
            f'`{largest.parameter}` of {outcome.set}/{outcome.case}.')


def _differences(pairs: Sequence[Pair], names: tuple[str, str]) -> str:
    """Return the cases in which something that counts differs."""
    rows = [
        (one.case, ' or '.join(one.truth.names), one.said, other.said, *(
            f'{_word(get(one))} → {_word(get(other))}' if get(one) != get(other) else ''
            for get in (lambda o: o.named, lambda o: o.placed, lambda o: o.near)))
        for one, other in pairs
        if not same_answer(one, other) or one.near != other.near]
    if not rows:
        return 'No case was answered differently.'
    return markdown(('case', 'hidden', f'{names[0]} said', f'{names[1]} said', 'name', 'place',
                     f'within {NEAR:g} × noise'), rows)


def _word(flag: bool | None) -> str:
    return {True: 'right', False: 'wrong', None: NONE}[flag]
