# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a program says on the terminal: a line for each sentence."""

from __future__ import annotations

import sys

from ..legible import legible


def complain(program: str, sentence: object) -> None:
    """Print a sentence to stderr, behind the name of the program or of a file."""
    print(f'{legible(program)}: {legible(str(sentence))}', file=sys.stderr, flush=True)
