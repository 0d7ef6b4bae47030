# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The unit of a time that its name says."""

from __future__ import annotations

import re

from booster_ros.records.conversion import parsed_unit
from booster_ros.records.unit_in_name import named

_UNIT_WORDS = {
    's': {'s', 'sec', 'secs', 'second', 'seconds', 'sekunden', 'sek'},
    'ms': {'ms', 'msec', 'msecs', 'millis', 'millisecond', 'milliseconds'},
    'us': {'us', 'µs', 'usec', 'usecs', 'micros', 'microsecond', 'microseconds'},
    'ns': {'ns', 'nsec', 'nsecs', 'nanos', 'nanosecond', 'nanoseconds'},
    'min': {'min', 'minute', 'minutes'},
    'h': {'h', 'hour', 'hours'},
}


def unit_in_time_name(name: str, unit_row: str = '') -> str | None:
    """Return the unit of time that a name (`time_ms`, `Time (s)`), or a row below, says."""
    for text in (named(name).unit, unit_row.strip('[](){} ')):
        unit = parsed_unit(text)
        if unit is not None and unit.pint.check('[time]'):
            return unit.written
    words = re.findall(r'[a-zµ]+', re.sub(r'(?<=[a-z])(?=[A-Z])', '_', name).lower())
    for unit_name, spellings in _UNIT_WORDS.items():
        if words and (words[-1] in spellings or words[0] in spellings):
            return unit_name
    return None
