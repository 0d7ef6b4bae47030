# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""That the benchmarks measure what they say; how fast anything is, no test asks."""

import re
import sys

import numpy as np
import pytest

from booster_ros.benchmark import accuracy, cases, long_records, scaling
from booster_ros.model.parameters import from_values


def test_a_slip_is_a_start_from_a_standstill():
    case = cases.stick_slip()
    assert scaling.slips(case) > 50
    without = dict(scaling.FRICTION)['none']
    assert scaling.slips(case._replace(parameters=from_values(without))) == 0


def test_slips_of_a_packing_that_yields_are_counted_and_its_friction_is_weighed():
    """A stem that climbs at 1 mm/s and slips twice, under a pressure that is 300 N too much."""
    steps = np.array([0.5, 0.5, 3.0, 2.0, 0.5, 0.0, 4.0, 0.5]) * 1e-5
    position = 0.004 + np.concatenate(([0.0], np.cumsum(steps)))
    p = cases.yielding_packing(200.0)
    found = accuracy.slipping(p, {
        'valve_position': position, 'stem_velocity': np.zeros(9),
        'chamber_pressure': 150e3 + 150e3 / 0.016 * position + 300.0 / 0.0796})
    assert found.slips == 2
    assert found.friction == pytest.approx(300.0)


def test_noise_of_a_case_is_the_same_in_all_runs():
    one, other = (cases.noisy_ramps(stiction, 4.0).control_current for stiction in (200.0, 0.0))
    assert np.array_equal(one, other)
    noise = one - cases.yielding_ramps(0.0, 4.0).control_current
    assert np.std(noise) == pytest.approx(cases.CURRENT_NOISE, rel=0.2)


def test_packings_that_yield_are_compared_with_the_strictest_run():
    head = accuracy.yielding_head().splitlines()[0]
    lines = accuracy.yielding_rows(cases.yielding_ramps(0.0, 2.0), rtol=1e-8)
    tolerances, errors, counts, friction = ([line.split(' | ')[at] for line in lines]
                                            for at in (2, 3, 7, 8))
    assert {line.count('|') for line in lines} == {head.count('|')}
    assert tolerances == ['1', '0.1', '0.01', '0.001', '0.0001', 'Radau']
    assert float(errors[4]) == 0.0
    # without stiction nothing is chance
    assert max(map(float, errors)) < 5.0
    assert len(set(counts)) == 1
    assert np.ptp([float(cell.strip(' |')) for cell in friction]) < 0.2


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
