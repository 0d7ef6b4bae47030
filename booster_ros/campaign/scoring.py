# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a diagnosis said of a case, against what is hidden there."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
import math
from typing import Any

from .cases import Truth

NEAR = 1.5
"""Up to so many times the noise, in every channel, the second record counts as met."""

MOST_EFFECTS = 3
"""More effects than these do not name two hidden ones: that would be a list of guesses."""

ANSWERED, FAILED, TIMEOUT = 'answered', 'failed', 'timeout'

Report = Mapping[str, Any]
Effects = Sequence[Mapping[str, Any]]


@dataclass(frozen=True)
class Interval:
    """
    An estimate of a parameter whose true value is known, with its 95 % interval, SI units.

    `of_effect` is false for a declared parameter.
    """

    parameter: str
    of_effect: bool
    truth: float
    value: float
    low: float
    high: float
    open_above: bool = False

    @property
    def holds(self) -> bool:
        """Whether the truth lies in the interval."""
        return self.low <= self.truth and (self.open_above or self.truth <= self.high)

    @property
    def widths(self) -> float:
        """How far the estimate is from the truth, in widths of the interval."""
        missed = abs(self.value - self.truth)
        if missed == 0.0 or (self.open_above and self.holds):
            return 0.0
        return missed / max(self.high - self.low, 1e-12 * missed)


@dataclass(frozen=True)
class Outcome:
    """
    What came of a case: `status` is ANSWERED, FAILED or TIMEOUT, `message` says why.

    `inputs` and `state` identify the case's files and the program. `cpu_seconds` are those of all
    cores together. `before` and `after` are RMS
    errors on the second record by channel, SI units, None where there are none. `found` are the
    effects of the report with name, location, confused_with, parameters, and standing and
    explained where the report has them; `held_out` is its largest error in the held-out part, over
    the noise.
    """

    set: str
    case: str
    inputs: str
    state: str
    status: str
    message: str
    seconds: float
    cpu_seconds: float
    truth: Truth
    verdict: str = ''
    found: tuple[Mapping[str, Any], ...] = ()
    before: Mapping[str, float] | None = None
    after: Mapping[str, float] | None = None
    intervals: tuple[Interval, ...] = ()
    held_out: float | None = None

    @property
    def answered(self) -> bool:
        """Whether there is a report."""
        return self.status == ANSWERED

    @property
    def said(self) -> str:
        """The names that were given, joined by '+', else the verdict, else the status."""
        return '+'.join(effect['name'] for effect in self.found) or self.verdict or self.status

    @property
    def named(self) -> bool:
        """Whether the name is right."""
        return self.answered and is_named(self.truth.names, self.verdict, self.found)

    @property
    def placed(self) -> bool:
        """Whether the place is right."""
        return self.answered and is_placed(self.truth.location, self.verdict, self.found)

    @property
    def near(self) -> bool | None:
        """Whether the second record is met to NEAR times its noise, None where it has none."""
        if not any(self.truth.noise.values()):
            return None
        worst = self.over_noise(self.after)
        return worst is not None and worst < NEAR

    @property
    def wrongly_confirmed(self) -> tuple[str, ...]:
        """Names that were called confirmed and are wrong."""
        right = {part for name in self.truth.names for part in name.split('+')}
        return tuple(
            effect['name'] for effect in self.found
            if effect.get('standing') == 'confirmed' and effect['name'] != 'unknown'
            and not right & {effect['name'], *effect['confused_with']})

    def over_noise(self, errors: Mapping[str, float] | None) -> float | None:
        """Return the largest error over its noise, None without any."""
        ratios = [error / self.truth.noise[channel] for channel, error in (errors or {}).items()
                  if self.truth.noise.get(channel)]
        return max(ratios, default=None)


def is_named(names: Sequence[str], verdict: str, effects: Effects) -> bool:
    """
    Tell whether what was found has a right name, or one that it is not told apart from.

    `names` are those that count as right; one with '+' asks for both, 'none' for nothing, and
    'unknown' is right where no more than that was found.
    """
    group = {name for effect in effects for name in (effect['name'], *effect['confused_with'])}
    for name in names:
        parts = set(name.split('+'))
        if name == 'none':
            right = verdict == 'none'
        elif len(parts) > 1:
            right = parts <= group and len(effects) <= MOST_EFFECTS
        else:
            right = name in group or name == verdict == 'unknown'
        if right:
            return True
    return False


def is_placed(location: str, verdict: str, effects: Effects) -> bool:
    """Tell whether something was found wherever something is hidden: 'a+b' both, 'a|b' either."""
    if location == 'none':
        return verdict == 'none'
    places = {effect['location'] for effect in effects}
    return any(set(either.split('+')) <= places for either in location.split('|'))


def answer_of(report: Report, truth: Mapping[str, float]) -> dict[str, Any]:
    """
    Return what an outcome keeps of a report, by the names of its fields.

    `truth` has true values by parameter. KeyError, TypeError or AttributeError where the report is
    none.
    """
    return {'verdict': str(report['verdict']), 'found': effects_of(report),
            'intervals': intervals_of(report, truth), 'held_out': held_out_of(report)}


def effects_of(report: Report) -> tuple[Mapping[str, Any], ...]:
    """Return of each effect of a report what a campaign keeps."""
    kept = ('name', 'location', 'confused_with', 'standing', 'explained', 'parameters')
    return tuple({'confused_with': [], 'location': '?', 'parameters': {},
                  **{name: effect[name] for name in kept if name in effect}}
                 for effect in report.get('effects', []))


def intervals_of(report: Report, truth: Mapping[str, float]) -> tuple[Interval, ...]:
    """Return the intervals of the parameters whose true values are known."""
    found = []
    for effect in report.get('effects', []):
        for name, estimate in effect.get('parameters', {}).items():
            found.append(_interval(name, True, truth, estimate, 'value'))
    for name, estimate in (report.get('declared_parameters') or {}).items():
        found.append(_interval(name, False, truth, estimate, 'after'))
    return tuple(interval for interval in found if interval is not None)


def _interval(name: str, of_effect: bool, truth: Mapping[str, float],
              estimate: Mapping[str, Any], value: str) -> Interval | None:
    """Return the interval, None where the truth or an end of it is not known."""
    found, low, high = (_number(estimate.get(key)) for key in (value, 'low', 'high'))
    if name not in truth or found is None or low is None or high is None:
        return None
    return Interval(name, of_effect, truth[name], found, low, high,
                    bool(estimate.get('open_above')))


def _number(value: object) -> float | None:
    return float(value) if isinstance(value, int | float) and math.isfinite(value) else None


def held_out_of(report: Report) -> float | None:
    """Return the largest error in the held-out part of the record over the noise found in it."""
    ratios = [error['after'] / error['noise'] for error in (report.get('held_out') or {}).values()
              if error.get('noise') and error.get('after') is not None]
    return max(ratios, default=None)


def values_of(outcome: Outcome) -> dict[str, Any]:
    """Return an outcome as plain values, with the judgements that follow from it."""
    values = asdict(outcome)
    for interval, plain in zip(outcome.intervals, values['intervals'], strict=True):
        plain |= {'holds': interval.holds, 'widths': interval.widths}
    return {**values, 'said': outcome.said, 'named': outcome.named, 'placed': outcome.placed,
            'near': outcome.near, 'wrongly_confirmed': outcome.wrongly_confirmed}


def outcome_of(values: Mapping[str, Any]) -> Outcome:
    """Return the outcome from what `values_of` made of it; KeyError or TypeError if it is none."""
    own = {name: values[name] for name in Outcome.__dataclass_fields__}
    truth = own.pop('truth')
    intervals = own.pop('intervals')
    found = own.pop('found')
    return Outcome(
        **own, found=tuple(found), truth=Truth(**{**truth, 'names': tuple(truth['names'])}),
        intervals=tuple(
            Interval(**{name: each[name] for name in Interval.__dataclass_fields__})
            for each in intervals))
