# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The table of changes: seen, place and name right, what was adopted, errors."""

from collections.abc import Sequence

import numpy as np

from .twin_change import NONE, Came

COLUMNS = (
    'change', 'runs', 'alarm', 'alarm or out of specification, median delay', 'place', 'name',
    'name or a declared rival', 'adopted: the true effect', 'with another one',
    'a declared rival', 'another one',     'error before → after, noise')
HEAD = f'| {" | ".join(COLUMNS)} |\n|' + len(COLUMNS) * '---|'

RIGHT, MORE, RIVAL, WRONG = 'right', 'more', 'rival', 'wrong'


def adopted(came: Came) -> str:
    """
    Return how a model was adopted, '' where none was.

    `RIGHT` is the true effect alone, `MORE` another one beside it, `RIVAL` one of which the report
    says that it may be the true one instead, `WRONG` all else.
    """
    if not came.adoption.startswith('adopted'):
        return ''
    if came.effects == [came.fault]:
        return RIGHT
    if came.fault in came.effects:
        return MORE
    return RIVAL if came.fault in came.group else WRONG


def table(all_came: Sequence[Came]) -> str:
    """Return a row for each change and one for all; runs with an alarm before it are left out."""
    counted = [one for one in all_came if not one.early]
    faults = list(dict.fromkeys(one.fault for one in counted if one.fault != NONE))
    rows = [_row(fault.replace('_', ' '), [one for one in counted if one.fault == fault])
            for fault in faults]
    rows.append(_row('all changes', [one for one in counted if one.fault != NONE]))
    sound = [one for one in counted if one.fault == NONE]
    if sound:
        rows.append(
            f'| no change | {len(sound)} | {sum(one.delay is not None for one in sound)} | '
            f'{sum(one.noticed is not None for one in sound)} | '
            f'{sum(one.kind == "nothing" for one in sound)} found nothing | | | | | | '
            f'{sum(adopted(one) == WRONG for one in sound)} | |')
    early = len(all_came) - len(counted)
    last = f'Called unwell before the change: {early} of {len(all_came)} runs.'
    return '\n'.join([HEAD, *rows, '', last])


def _row(name: str, runs: Sequence[Came]) -> str:
    delays = [one.noticed for one in runs if one.noticed is not None]
    how = [adopted(one) for one in runs]
    kept = [one for one in runs if one.after is not None]
    errors = '' if not kept else (f'{np.median([one.before for one in kept]):.1f} → '
                                  f'{np.median([one.after for one in kept]):.2f}')
    alarms = sum(one.delay is not None for one in runs)
    return (f'| {name} | {len(runs)} | {alarms} | {len(delays)}'
            + (f', {np.median(delays):.0f} s' if delays else '')
            + f' | {sum(one.place in one.places for one in runs)} '
            f'| {sum(one.fault in one.effects for one in runs)} '
            f'| {sum(one.fault in one.group for one in runs)} '
            f'| {" | ".join(str(how.count(one)) for one in (RIGHT, MORE, RIVAL, WRONG))} '
            f'| {errors} |')
