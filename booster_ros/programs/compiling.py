# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Tell the user why the first run on a machine starts late, or why all runs are slow."""

from __future__ import annotations

import sys

from ..model import compiled


def announce_compilation() -> None:
    """Print one line to stderr where the model is about to be compiled, or cannot be."""
    notice = compilation_notice()
    if notice:
        print(notice, file=sys.stderr, flush=True)


def compilation_notice() -> str:
    """Return the line, empty where machine code is ready."""
    if not compiled.available():
        return 'numba is not installed: the model runs in plain Python, some thirty times slower'
    if compiled.cache_folder() is None:
        return (
            'compiling the model (about half a minute) for this run only: no cache folder can be '
            'written, set XDG_CACHE_HOME to one that can'
        )
    if not compiled.is_cached():
        return 'compiling the model once for this machine (about half a minute) ...'
    return ''
