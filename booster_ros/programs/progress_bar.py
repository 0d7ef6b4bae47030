# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The bar that a program shows while it works."""

from __future__ import annotations

from tqdm import tqdm


class ProgressBar(tqdm):
    """
    Tqdm's bar without its thread, which watches bars that are seldom updated.

    A program that was interrupted at the moment in which the bar starts that thread waited for the
    thread for ever instead of ending.
    """

    monitor_interval = 0
