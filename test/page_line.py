# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A line of a page, carried out as it stands."""

from contextlib import redirect_stdout
import io
import os
from pathlib import Path
import shlex
import subprocess

from booster_ros.__main__ import main

OURS = ['python', '-m', 'booster_ros']


def typed(line: str, place: Path) -> str:
    """
    Return what a line prints when it is typed in a folder.

    Programs of the package run in this process, which has their libraries already.
    """
    words = shlex.split(line)
    if words[:3] != OURS:
        done = subprocess.run(['bash', '-c', line], cwd=place, capture_output=True, text=True,
                              timeout=300, check=False)
        assert done.returncode == 0, (line, done.stderr)
        return done.stdout
    said, before = io.StringIO(), Path.cwd()
    os.chdir(place)
    try:
        with redirect_stdout(said):
            assert main(words[3:]) == 0, line
    finally:
        os.chdir(before)
    return said.getvalue()
