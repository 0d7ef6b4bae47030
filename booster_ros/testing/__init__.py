# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Tests of controllers against a simulated valve, tick by tick: see docs/testing.md."""

from .bench import Band, Bench, Controller
from .remote_valve import RemoteValve
from .series import Sample, Series
from .valve import Valve

__all__ = ['Band', 'Bench', 'Controller', 'RemoteValve', 'Sample', 'Series', 'Valve']
