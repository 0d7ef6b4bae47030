# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Names of columns with their units in them: `P act (psi)`, `Feedback_kPa`, `Travel [%]`."""

from __future__ import annotations

import re
from typing import NamedTuple

from booster_ros.records.conversion import LONGEST_UNIT, is_usual, parsed_unit

_BRACKETS = re.compile(r'(.*?)[\s_]*[\[({<]\s*([^\[\](){}<>]*(?:\([^()]*\))?)\s*[\])}>]\s*')
_BEHIND = re.compile(r'(.*?\w)(?:\s*[,/]\s*|[\s_.\-]+in[\s_.\-]+|[\s_.\-]+)([^\s_,.\-/]+(?:/\w+)?)')
_LONGEST = 80
"""Characters of the longest name in which a unit is looked for."""


class Named(NamedTuple):
    """A name without the unit, and the unit as it is written, '' where there is none."""

    name: str
    unit: str


def named(text: str) -> Named:
    """Return a name and the unit in it; brackets with something else stay in the name."""
    whole = text.strip()
    if len(whole) > _LONGEST:
        return Named(whole, '')
    bracketed = _BRACKETS.fullmatch(whole) if whole[-1:] in ('])}>') and whole else None
    if bracketed and len(bracketed[2]) <= LONGEST_UNIT and parsed_unit(bracketed[2]) is not None:
        return Named(bracketed[1].strip(), bracketed[2].strip())
    behind = _BEHIND.fullmatch(whole)
    # one letter may be anything, 'P_s' a supply
    if behind and is_usual(behind[2]) and (len(behind[2]) > 1 or behind[2] in '%s'):
        return Named(behind[1].strip(), behind[2])
    return Named(whole, '')


def normalised(name: str) -> str:
    """Return a name in small letters, words separated by underscores."""
    return re.sub(r'[\s\-]+', '_', name.strip().lower())
