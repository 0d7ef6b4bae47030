# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A process that writes again and again, and is killed in the middle of it."""

from __future__ import annotations

import os
from pathlib import Path
import random
import signal
import subprocess
import sys
import time


def killed_writer(script: str, path: Path, least: int) -> int:
    """
    Run a script that writes to `path` and tells the number of each writing, and kill it.

    It is killed at some moment after it has told `least`; return the last number that it told.
    """
    writer = subprocess.Popen(
        [sys.executable, '-c', script, str(path)], stdout=subprocess.PIPE, cwd=os.getcwd())
    assert writer.stdout is not None
    for line in writer.stdout:
        if int(line) >= least:
            break
    time.sleep(0.05 * random.random())
    writer.send_signal(signal.SIGKILL)
    return [int(line), *map(int, writer.communicate()[0].split())][-1]
