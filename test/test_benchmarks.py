# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""That the benchmarks measure what they say; how fast anything is, no test asks."""

import re
import sys

import numpy as np
import pytest

from booster_ros.benchmark import cases, long_records, scaling
from booster_ros.model.parameters import from_values


def test_a_slip_is_a_start_from_a_standstill():
    case = cases.stick_slip()
    assert scaling.slips(case) > 50
    without = dict(scaling.FRICTION)['none']
    assert scaling.slips(case._replace(parameters=from_values(without))) == 0


def test_a_long_record_comes_in_portions_that_make_a_whole():
    portions = list(long_records.rows(0.5))
    assert [len(t) for t, _ in portions] == [60_000, 60_000, 60_000]
    time = np.concatenate([t for t, _ in portions])
    assert time[-1] == pytest.approx(1800.0 - 0.01)
    assert np.ptp(np.diff(time)) < 1e-9


def test_the_cost_of_a_command_is_its_own():
    burn = 'import time; a = bytearray(200_000_000)\nwhile time.process_time() < 0.3: pass'
    cost = long_records.cost_of([sys.executable, '-c', burn])
    assert cost.cpu >= 0.3
    assert cost.wall >= 0.29
    assert cost.memory > 200e6
    here = bytearray(200_000_000)
    assert long_records.cost_of([sys.executable, '-c', 'pass']).memory < 0.5 * len(here)
    with pytest.raises(RuntimeError, match='failed'):
        long_records.cost_of([sys.executable, '-c', 'raise SystemExit(3)'])


def test_long_records_are_simulated_by_the_command(monkeypatch):
    monkeypatch.setattr(long_records, 'HOURS', (0.01,))
    line = long_records.document().splitlines()[-1]
    assert re.fullmatch(r'\| 0\.01 h \| 0\.00 million \|( [\d.]+ \|){3} \d+ % \| \d+ \|', line)
