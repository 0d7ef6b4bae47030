# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
CUSUM, Page-Hinkley and ADWIN on the numbers that the twin judges, at its rate of false alarms.

They are told mean and standard deviation of each number from the time of learning. Thresholds are
the least at which no more clean runs have an alarm than the twin's promise allows.
"""

from collections.abc import Callable
import importlib.util

import numpy as np

from .twin_valves import LASTS, LEARNING, NAMES, PROMISES, Run, first_seen

PROMISED = PROMISES[-1]
"""False alarms per 1000 h at which all are compared: enough to be counted in some hundred hours."""

SLACK = 0.5
"""Standard deviations that CUSUM and Page-Hinkley let pass: half of a change by one."""


def standardised(run: Run) -> tuple[np.ndarray, np.ndarray]:
    """Return ends, s, and numbers of the blocks after learning, by what they were there."""
    table = np.array([[block.numbers.get(name, np.nan) for name in NAMES]
                      for block in run.blocks])
    ends = np.array([block.end for block in run.blocks])
    learnt = ends <= LEARNING
    with np.errstate(all='ignore'):
        mean = np.nanmean(table[learnt], axis=0)
        deviation = np.nanstd(table[learnt], axis=0)
    scaled = (table - mean) / np.where(deviation > 0.0, deviation, 1.0)
    return ends[~learnt], np.nan_to_num(scaled[~learnt])


def cusum(numbers: np.ndarray) -> np.ndarray:
    """Return the largest two-sided cumulative sum at each block (E. S. Page, 1954)."""
    high = low = np.zeros(numbers.shape[1])
    seen = []
    for x in numbers:
        high = np.maximum(high + x - SLACK, 0.0)
        low = np.maximum(low - x - SLACK, 0.0)
        seen.append(max(high.max(), low.max()))
    return np.array(seen)


def page_hinkley(numbers: np.ndarray) -> np.ndarray:
    """Return the largest rise above the least sum, about a running mean (D. V. Hinkley, 1971)."""
    mean = np.cumsum(numbers, axis=0) / np.arange(1, len(numbers) + 1)[:, None]
    found = np.zeros(len(numbers))
    for sign in (1.0, -1.0):
        total = np.cumsum(sign * (numbers - mean) - SLACK, axis=0)
        rise = total - np.minimum.accumulate(total, axis=0)
        found = np.maximum(found, rise.max(axis=1))
    return found


def adwin(numbers: np.ndarray) -> np.ndarray:
    """Return, at each block, minus log10 of the least delta tried at which ADWIN alarms there."""
    from river.drift import ADWIN
    found = np.zeros(len(numbers))
    for exponent in (1, 2, 3, 5, 8, 12, 20, 40):
        for column in numbers.T:
            detector = ADWIN(delta=10.0**-exponent, clock=1)
            for k, x in enumerate(column.tolist()):
                detector.update(x)
                if detector.drift_detected:
                    found[k] = max(found[k], exponent)
    return found


def rivals(clean: list[Run]) -> dict[str, Callable[[Run], float | None]]:
    """Return what tells the delay, s, of each rival on a run, thresholds set on clean runs."""
    known: dict[str, Callable[[np.ndarray], np.ndarray]] = {
        'CUSUM': cusum, 'Page-Hinkley': page_hinkley}
    if importlib.util.find_spec('river') is not None:
        known['ADWIN'] = adwin
    hours = len(clean) * (LASTS - LEARNING) / 3600.0
    allowed = int(PROMISED * hours / 1000.0)
    found = {}
    for name, statistic in known.items():
        peaks = np.sort([statistic(standardised(run)[1]).max() for run in clean])
        limit = float(peaks[-1 - allowed])
        found[f'{name} above {limit:.3g}'] = _delay_of(statistic, limit)
    return found


def _delay_of(statistic: Callable[[np.ndarray], np.ndarray], limit: float
              ) -> Callable[[Run], float | None]:
    def delay(run: Run) -> float | None:
        ends, numbers = standardised(run)
        return first_seen(ends[statistic(numbers) > limit], run.changed)

    return delay
