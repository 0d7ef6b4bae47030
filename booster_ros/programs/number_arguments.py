# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Numbers on the command line, checked where argparse reads them."""

from __future__ import annotations

import argparse
from collections.abc import Callable


def count_of(what: str) -> Callable[[str], int]:
    """Return the type of an argument that counts something, from 1 on."""

    def count(text: str) -> int:
        if not text.isdecimal() or int(text) < 1:
            raise argparse.ArgumentTypeError(f'{text!r} is not a number of {what}')
        return int(text)

    return count


def seconds(text: str) -> float:
    """Return a time in seconds, finite and above zero, for argparse."""
    try:
        found = float(text)
    except ValueError:
        found = 0.0
    if not 0.0 < found < float('inf'):
        raise argparse.ArgumentTypeError(f'{text!r} is not a time in seconds')
    return found
