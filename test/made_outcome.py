# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Outcomes of a campaign, written by hand."""

from collections.abc import Mapping, Sequence

from booster_ros.campaign.cases import Truth
from booster_ros.campaign.scoring import ANSWERED, Interval, Outcome


def found(name: str, location: str, *rivals: str, standing: str = '', **sizes: Sequence[float]
          ) -> dict:
    """Return an effect as a report lists it; sizes are (value, low, high)."""
    effect = {'name': name, 'location': location, 'confused_with': list(rivals), 'parameters': {
        key.replace('__', '.'): {'value': value, 'low': low, 'high': high, 'unit': 'N'}
        for key, (value, low, high) in sizes.items()}}
    return {**effect, 'standing': standing} if standing else effect


LEAK = found('chamber_leak', 'chamber', 'exhaust_seat_leak')
FRICTION = found('stem_friction', 'stem')
UNKNOWN = found('unknown', 'stem')


def outcome(
    case: str, *effects: Mapping, names: Sequence[str] = ('none',), location: str = 'none',
    after: Mapping[str, float] | None = None, intervals: Sequence[Interval] = (),
    noise: Mapping[str, float] | None = None, **fields,
) -> Outcome:
    """Return what came of a case; it was answered unless `status` says something else."""
    truth = Truth(tuple(names), location) if noise is None else Truth(
        tuple(names), location, noise)
    verdict = 'none' if not effects else (
        'unknown' if effects[0]['name'] == 'unknown' else 'effect')
    values = {
        'set': 'set', 'case': case, 'inputs': 'i', 'state': 's', 'status': ANSWERED, 'message': '',
        'seconds': 10.0, 'cpu_seconds': 8.0, 'truth': truth, 'verdict': verdict,
        'found': tuple(effects), 'before': after, 'after': after, 'intervals': tuple(intervals),
    }
    return Outcome(**{**values, **fields})
