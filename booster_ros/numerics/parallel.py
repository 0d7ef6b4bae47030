# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Several runs of the model side by side, on all processors: the model releases Python's lock."""

from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
import os
from typing import TypeVar

One = TypeVar('One')
Found = TypeVar('Found')


def side_by_side(function: Callable[[One], Found], several: Iterable[One]) -> list[Found]:
    """
    Return what the function returns for each, in their order; what it raises is raised.

    The threads last no longer than the call: a pool that outlived an interruption in the middle of
    starting a thread would keep the process from ending.
    """
    with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
        return list(pool.map(function, several))
