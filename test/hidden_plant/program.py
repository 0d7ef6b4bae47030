# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Running a program of the package as anyone would start it."""

from pathlib import Path
import subprocess
import sys

ROOT = Path(__file__).resolve().parents[2]


class RunError(Exception):
    """A run of a program that failed; its text is what the program said."""


def run_program(name: str, *words: str | Path) -> None:
    """Run a program of the package from its sources; RunError if that fails."""
    done = subprocess.run(
        [sys.executable, '-m', 'booster_ros', name, *map(str, words)],
        cwd=ROOT, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RunError(done.stderr.strip().splitlines()[-1] if done.stderr.strip() else
                       f'{name} ended with {done.returncode}')
