# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Tell the user why the first run on a machine starts late, or why all runs are slow."""

from __future__ import annotations

import sys

from ..model import code_cache, compiled


def announce_compilation() -> None:
    """
    Print a line to stderr where the model is about to be compiled, or cannot be.

    Machine code that was damaged since is removed, so that it is made anew, and that is said.
    """
    for notice in compilation_notices():
        print(notice, file=sys.stderr, flush=True)


def compilation_notices() -> tuple[str, ...]:
    """Return the lines, none where machine code is ready; remove what is damaged."""
    if not compiled.available():
        return ('numba is not installed: the model runs in plain Python, some thirty times slower',)
    folder, distrusted = compiled.cache_place()
    notices = []
    if distrusted is not None:
        kept = 'it is not kept' if folder is None else f'it is kept in {folder}'
        notices.append(
            f'others may have written to {distrusted}, from which machine code would be run: {kept}'
            ', until that folder and the one it is in are yours alone (mode 700), or removed')
    if folder is None:
        helps = '' if distrusted else (
            ': no cache folder can be written, set XDG_CACHE_HOME to one that can')
        notices.append(f'compiling the model (about a minute) for this run only{helps}')
        return tuple(notices)
    damaged = code_cache.remove_damaged(folder)
    if damaged:
        notices.append(f'{len(damaged)} damaged file{"s" if len(damaged) > 1 else ""} of the '
                       f'compiled model removed, as of {damaged[0]}')
    if not compiled.is_cached():
        notices.append('compiling the model once for this machine (about a minute) ...')
    return tuple(notices)
