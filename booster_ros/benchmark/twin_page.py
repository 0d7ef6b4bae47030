# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The tables of docs/twin.md: an exact interval, a row, and the place between two markers."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from scipy.stats import chi2

PAGE = Path(__file__).parents[2] / 'docs' / 'twin.md'
BEGIN = '<!-- made by: {command} -->'
END = '<!-- end -->'


def interval(count: int) -> tuple[float, float]:
    """Return the exact 95 % interval of a Poisson mean (F. Garwood, Biometrika 28 (1936) 437)."""
    low = 0.5 * float(chi2.ppf(0.025, 2 * count)) if count else 0.0
    return low, 0.5 * float(chi2.ppf(0.975, 2 * count + 2))


def rate_row(name: str, hours: float, promised: float, alarms: int) -> str:
    """Return a row on false alarms; `promised` is per 1000 h."""
    low, high = (1000.0 * end / hours for end in interval(alarms))
    return (f'| {name} | {hours:.0f} | {promised:.3g} | {alarms} | '
            f'{1000.0 * alarms / hours:.3g} ({low:.2g} to {high:.2g}) |')


def seen(delays: Sequence[float | None]) -> str:
    """Return share detected and median delay, s (None: not seen), of runs not alarmed before."""
    counted = [delay for delay in delays if delay is None or not np.isnan(delay)]
    found = [delay for delay in counted if delay is not None]
    share = f'{len(found)} of {len(counted)}'
    return f'{share}, {np.median(found):.0f} s' if found else share


def write(tables: str, command: str) -> None:
    """Put the tables between the markers that a command has on the page."""
    begin = BEGIN.format(command=command)
    text = PAGE.read_text(encoding='utf-8')
    before, rest = text.split(begin)
    after = rest.split(END, 1)[1]
    PAGE.write_text(f'{before}{begin}\n\n{tables}\n\n{END}{after}', encoding='utf-8')
