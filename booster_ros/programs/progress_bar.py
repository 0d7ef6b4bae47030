# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The bar that a program shows while it works."""

from __future__ import annotations

from tqdm import tqdm


class ProgressBar(tqdm):
    """
    Tqdm's bar without its thread, which watches bars that are seldom updated.

    Interrupted at the moment in which it starts that thread, a program waited for it for ever
    instead of ending.
    """

    monitor_interval = 0
