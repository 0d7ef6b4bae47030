# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a diagnosis found, in a sentence: what the valve lacks, since when, how sure."""

from collections.abc import Mapping
import json
import math
from pathlib import Path
import time
from typing import Any, NamedTuple

NOTHING, FOUND, FAILED = 'nothing', 'found', 'failed'

CLOCK_OF_DAY = 1e8
"""Times, s, from which a stamp is one of the clock on the wall, not of a simulation."""


class VerdictError(ValueError):
    """A report that is not there or cannot be read; the message is one sentence that names it."""


class Verdict(NamedTuple):
    """What came of a diagnosis."""

    kind: str
    """`NOTHING` is missing, something was `FOUND`, or the diagnosis `FAILED`."""
    sentence: str
    folder: str
    """Where report and found model are."""
    since: float
    """Since when, s, the valve is so, as the alarm says; NaN where there was none."""
    standing: str
    """The least sure of what was found: confirmed, likely or candidate; '' where nothing was. It is
    candidate where much is left that nothing explains."""
    effects: tuple[str, ...]
    adoption: str = ''
    """What became of the found model, '' where it was not asked for."""
    uncertainty: Mapping[str, float] | None = None
    """What the found model misses of each channel, root mean square (SI), in data that no step of
    the diagnosis had seen."""

    @property
    def is_confirmed(self) -> bool:
        """Whether all that was found is."""
        return self.kind == FOUND and self.standing == 'confirmed'


LEAST = 0.1
"""Share of what was missing that one of the effects has to explain for more than a candidate."""

_MORE = ', and more than that'
"""How the headline of a report ends where much is left."""

_STANDINGS = ('confirmed', 'likely', 'candidate')


def moment(stamp: float) -> str:
    """
    Return a time stamp, s, as people say it.

    >>> moment(132.04)
    '132.0 s'
    """
    if stamp < CLOCK_OF_DAY:
        return f'{stamp:.1f} s'
    there = time.localtime(stamp)
    today = there[:3] == time.localtime()[:3]
    return time.strftime('%H:%M:%S' if today else '%Y-%m-%d %H:%M:%S', there)


def failed(reason: str, folder: Path, since: float) -> Verdict:
    """Return the verdict of a diagnosis that came to no end."""
    return Verdict(FAILED, f'the diagnosis failed: {reason}', str(folder), since, '', ())


def verdict_of(folder: Path, since: float) -> Verdict:
    """Return the verdict in the `report.json` of a folder; VerdictError where there is none."""
    path = folder / 'report.json'
    try:
        report = json.loads(path.read_text(encoding='utf-8'))
        return _verdict(report, folder, since)
    except OSError as error:
        raise VerdictError(f'{path}: {error.strerror}') from None
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise VerdictError(f'{path} cannot be read: {error!r}') from None


def _verdict(report: Mapping[str, Any], folder: Path, since: float) -> Verdict:
    effects = report['effects']
    uncertainty = {name: float(one['after']) for name, one in report['held_out'].items()
                   if one['after'] is not None}
    if report['verdict'] == 'none':
        return Verdict(NOTHING, report['summary'], str(folder), since, '', ())
    standing = max((one['standing'] for one in effects), key=_STANDINGS.index, default='candidate')
    if report['verdict'] == 'effect':
        headline = _headline(report['summary'])
        what = 'the valve has ' + ' and '.join(
            f'{_plain(one["name"])} ({_share(one["explained"])}{one["standing"]})'
            for one in effects)
        if headline.endswith(_MORE):
            what += _MORE
        if headline.endswith(_MORE) or max(one['explained'] or 0.0 for one in effects) < LEAST:
            standing = 'candidate'
    else:  # what has no name is at most as sure as that something is there
        what, standing = _headline(report['summary']), 'candidate'
    return Verdict(
        FOUND, '; '.join([f'{what}, {_when(since)}', *_open_questions(effects)]), str(folder),
        since, standing, tuple(one['name'] for one in effects), uncertainty=uncertainty)


def _plain(name: str) -> str:
    return name.replace('_', ' ')


def _share(explained: float | None) -> str:
    if explained is None:
        return ''
    return f'explains {math.floor(100.0 * explained)} % of what was missing, '


def _headline(summary: str) -> str:
    return summary.partition('. ')[0].rstrip('.')


def _when(since: float) -> str:
    return 'since when is not known, as there was no alarm' if math.isnan(since) else (
        f'since {moment(since)}')


def _open_questions(effects: list[Mapping[str, Any]]) -> list[str]:
    """Return what each effect may be instead, and which record would decide, where one is named."""
    said = []
    for one in effects:
        rivals = ' or '.join(map(_plain, one['confused_with']))
        if rivals:
            said.append(f'it may be {rivals} instead')
        if one['separating_experiment'] and (rivals or one['standing'] != 'confirmed'):
            said.append(f'this would decide: {one["separating_experiment"]}')
    return said
