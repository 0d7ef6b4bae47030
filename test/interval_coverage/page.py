# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The page: how often intervals hold the truth, and how near levels of noise come, as Markdown."""

from collections.abc import Mapping, Sequence
import textwrap

import numpy as np
from scipy.stats import binomtest

from .fits import Held

_ABOUT = """
A valve that was written apart from the model (`test/hidden_plant`) is drawn anew for each record:
declared parameters from the tolerances that a refit allows them, cut at two standard deviations,
the effect's size evenly by its logarithm between small and large. The record is 100 s of current,
chamber pressure and valve position with the noise and the resolution of the samples. The effect is
told: a diagnosis that knows of no other one fits it, in the end to all but the locked part, and
its 95 % intervals are compared with what was put in. Whether a search of the whole catalogue would
have named it is another question, which [the matrix](confusion.md) answers.
"""

_NOISE = """
Level of the noise as `close_loop` has it, relative to what it is: what lies below 5, 50 and 95 % of
the records, pressure and position together. *Carried over* is the share of the noise that carries
over from a row to the next, 10 ms later; 0.9 is a sensor that is damped by 0.1 s. Stairs rest for
4 to 11 s. The sines, of periods from 3 to 30 s, never rest; there smooth motion tells the noise.
Hops, every half a second, are neither rest nor smooth: there the noise is taken as white, and the
report says what that means.
"""

_WORST = 4


def page(held: Mapping[tuple[str, float], Sequence[Sequence[Held]]],
         levels: Mapping[tuple[str, float], Sequence[float]], command: str) -> str:
    """
    Return the page.

    `held` has the records by effect and colour of the noise, each with its parameters; `levels`
    has relative levels of noise by kind of current and colour. `command` made them.
    """
    return '\n\n'.join([
        '# How far intervals and levels of noise hold',
        f'Made, from the folder `test`, by\n\n```\n{command}\n```',
        '## Intervals', textwrap.fill(_ABOUT.strip(), 120), _intervals(held), _parameters(held),
        '## Noise', textwrap.fill(_NOISE.strip(), 120), _levels(levels),
    ]) + '\n'


def _intervals(held: Mapping[tuple[str, float], Sequence[Sequence[Held]]]) -> str:
    lines = ['| effect | noise carried over | records | sizes held | declared parameters held |',
             '|---|---|---|---|---|']
    for (effect, carried), records in held.items():
        lines.append(f'| {effect or "none"} | {carried:g} | {len(records)} | '
                     f'{_share(_each(records, True))} | {_share(_each(records, False))} |')
    everything = [record for records in held.values() for record in records]
    lines.append(f'| **all** | | {len(everything)} | {_share(_each(everything, True), True)} | '
                 f'{_share(_each(everything, False), True)} |')
    return '\n'.join(lines)


def _parameters(held: Mapping[tuple[str, float], Sequence[Sequence[Held]]]) -> str:
    """Return the declared parameters that are held least often."""
    by_name: dict[str, list[bool]] = {}
    for records in held.values():
        for one in (one for record in records for one in record if not one.of_effect):
            by_name.setdefault(one.parameter, []).append(one.held)
    ranked = sorted(by_name.items(), key=lambda item: np.mean(item[1]))
    listed = ', '.join(f'`{name}` {_share(values)}' for name, values in ranked[:_WORST])
    return f'Held least often, of declared parameters: {listed}.'


def _each(records: Sequence[Sequence[Held]], of_effect: bool) -> list[bool]:
    return [one.held for record in records for one in record if one.of_effect is of_effect]


def _share(held: Sequence[bool], with_interval: bool = False) -> str:
    """Return how many are held; the interval is of the rate, as if all were independent."""
    if not held:
        return '–'
    text = f'{sum(held)} of {len(held)}'
    if not with_interval:
        return text
    found = binomtest(sum(held), len(held)).proportion_ci(method='wilson')
    return (f'{text}: {100 * sum(held) / len(held):.1f} % '
            f'({100 * found.low:.1f} to {100 * found.high:.1f})')


def _levels(levels: Mapping[tuple[str, float], Sequence[float]]) -> str:
    lines = ['| current | carried over | records | 5 % | median | 95 % |',
             '|---|---|---|---|---|---|']
    for (kind, carried), found in levels.items():
        low, middle, high = np.quantile(found, [0.05, 0.5, 0.95])
        lines.append(f'| {kind} | {carried:g} | {len(found) // 2} | {low:.2f} | {middle:.2f} | '
                     f'{high:.2f} |')
    return '\n'.join(lines)
