# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Judging what close_loop said against what was hidden."""

from collections.abc import Sequence
from typing import NamedTuple

from ..effects import EFFECTS

OUTCOMES = {
    'right': ('●', 'the right name (nothing: nothing; a structure without a name: `unknown`, in '
              'the right place)'),
    'group': ('◐', 'another name of the group that no record of these channels can tell apart, or '
              'the right one reported as not told apart from the named one; for a structure '
              'without a name: its nearest name'),
    'part': ('◔', 'one of two right, or the right one and another beside it'),
    'location': ('○', 'a wrong name in the right place'),
    'unknown': ('?', '`unknown` where there is a name, or in a wrong place'),
    'none': ('–', 'nothing found'),
    'wrong': ('✕', 'a wrong name in a wrong place, or anything on a clean record'),
}
"""Outcomes, best first: symbol and meaning."""


class Found(NamedTuple):
    """An effect that was reported: name, location, and what it was not told apart from."""

    name: str
    location: str
    confused_with: tuple[str, ...] = ()


class Judgement(NamedTuple):
    """An outcome (key of OUTCOMES), and whether every place was right."""

    outcome: str
    placed: bool


def judge(hidden: Sequence[str], found: Sequence[Found]) -> Judgement:
    """
    Return how what was found (nothing for the verdict none) suits the hidden keys of EFFECTS.

    Places are right where each hidden effect is where one was found and none is elsewhere.
    """
    if not hidden or not found:
        if not hidden and not found:
            return Judgement('right', True)
        return Judgement('none' if hidden else 'wrong', False)
    placed = _each_has_its_own(hidden, found, _placed)
    if [one.name for one in found] == ['unknown']:
        expected = placed and all(EFFECTS[key].names[0] == 'unknown' for key in hidden)
        return Judgement('right' if expected else 'unknown', placed)
    for outcome, suits in (('right', _named), ('group', _in_group)):
        if _each_has_its_own(hidden, found, suits):
            return Judgement(outcome, placed)
    if any(_in_group(key, one) for key in hidden for one in found):
        return Judgement('part', placed)
    return Judgement('location' if placed else 'wrong', placed)


def _each_has_its_own(hidden, found, suits) -> bool:
    """Tell whether hidden and found effects suit each other one by one, none left over."""
    if len(hidden) != len(found):
        return False
    if not hidden:
        return True
    return any(
        suits(hidden[0], one) and _each_has_its_own(hidden[1:], [*found[:k], *found[k + 1:]], suits)
        for k, one in enumerate(found))


def _named(key: str, found: Found) -> bool:
    return found.name == EFFECTS[key].names[0]


def _in_group(key: str, found: Found) -> bool:
    own, *equals = EFFECTS[key].names
    return found.name in (own, *equals) or own in found.confused_with


def _placed(key: str, found: Found) -> bool:
    # where two names are the same air or the same bend, so are their places
    return found.location == EFFECTS[key].location or (
        found.name in EFFECTS[key].names and found.name != 'unknown')
