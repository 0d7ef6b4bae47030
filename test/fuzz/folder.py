# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A folder for the files of one input."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
import shutil
import tempfile


@contextmanager
def folder() -> Iterator[Path]:
    """Return a folder of its own, gone afterwards."""
    place = Path(tempfile.mkdtemp(prefix='fuzz.'))
    try:
        yield place
    finally:
        shutil.rmtree(place, ignore_errors=True)
