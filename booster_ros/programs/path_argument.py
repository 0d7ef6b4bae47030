# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A path on the command line."""

from argparse import ArgumentTypeError
from pathlib import Path


def given_path(text: str) -> Path:
    """
    Return the path, for argparse.

    ArgumentTypeError where it is empty: pathlib takes that for the current folder, but it comes
    from a variable that is not set.
    """
    if not text:
        raise ArgumentTypeError("'' is no path")
    return Path(text)
