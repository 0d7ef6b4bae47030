# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The condition of a valve by the last minutes: friction, spring range, leak, times."""

import numpy as np
import pytest

from booster_ros.model.parameters import from_values
from booster_ros.model.simulation import simulate
from booster_ros.twin.condition import Condition, condition

MODEL = from_values({})
TIME = np.arange(0.0, 60.0, 0.01)
SINES = 0.433e-3 + 13e-6 * np.sin(np.outer((1.3, 3.5, 5.2), TIME)).sum(axis=0)
NOISE = {'chamber_pressure': 150.0, 'valve_position': 8e-6}


def rows_of(values, current=SINES, time=TIME):
    """Return rows of a valve with these parameters, read with noise."""
    run = simulate(from_values(values), time, current, {'chamber_pressure': 225e3})
    random = np.random.default_rng(1)
    return {'time': time, 'control_current': current} | {
        name: run[f'measured_{name}'] + level * random.standard_normal(len(time))
        for name, level in NOISE.items()}


def test_a_valve_that_is_as_its_model_has_neither_friction_nor_leak_nor_dead_time():
    found = condition(rows_of({}), MODEL)
    assert found.friction < 3.0
    assert found.dead_band < 1e-3
    assert found.spring_range_low == pytest.approx(150e3, abs=100.0)
    assert found.spring_range_high == pytest.approx(300e3, abs=100.0)
    assert found.leak_area < 2e-9
    assert found.dead_time < 1e-3


@pytest.mark.parametrize(('values', 'expected', 'error'), [
    ({'actuator.coulomb_friction': 100.0}, {'friction': 100.0, 'dead_band': 0.0167}, 0.1),
    ({'actuator.bench_set_shift': 2e3},
     {'spring_range_low': 152e3, 'spring_range_high': 302e3}, 1e-3),
    ({'actuator.leak_area': 5e-8}, {'leak_area': 5e-8}, 0.1),
    ({'ep_converter.dead_time': 0.03}, {'dead_time': 0.03}, 0.05)])
def test_what_has_changed_is_told_with_its_size(values, expected, error):
    found = condition(rows_of(values), MODEL)._asdict()
    for name, size in expected.items():
        assert found[name] == pytest.approx(size, rel=error)
    others = {'friction': 3.0, 'leak_area': 2e-9, 'dead_time': 1.5e-3}
    assert all(found[name] < most for name, most in others.items() if name not in expected)


def test_another_zero_of_the_converter_is_no_leak():
    assert condition(rows_of({'ep_converter.offset': 1e3}), MODEL).leak_area < 2e-9


def test_what_the_adopted_model_has_is_counted_in():
    worn = {'actuator.leak_area': 5e-8, 'ep_converter.dead_time': 0.03,
            'actuator.bench_set_shift': 2e3}
    found = condition(rows_of(worn), from_values(worn))
    assert found.leak_area == pytest.approx(5e-8, rel=0.05)
    assert found.dead_time == pytest.approx(0.03, rel=0.05)
    assert found.spring_range_low == pytest.approx(152e3, rel=1e-3)


def test_t86_is_that_of_the_steps():
    """A first-order lag of 0.8 s comes to 86.5 % after 1.6 s."""
    time = np.arange(0.0, 80.0, 0.05)
    asked = np.where(time // 10.0 % 2.0 == 0.0, 4e-3, 8e-3)
    position, place = np.empty(len(time)), asked[0]
    for k, target in enumerate(asked):
        position[k] = place
        place += (target - place) * (1.0 - np.exp(-0.05 / 0.8))
    found = condition({'time': time, 'set_point': asked, 'valve_position': position}, MODEL)
    assert found.t86 == pytest.approx(0.8 * np.log(1.0 / 0.135), abs=0.06)
    assert list(found.values) == ['T86 [s]']


@pytest.mark.parametrize('missing', ['chamber_pressure', 'valve_position', 'control_current'])
def test_what_the_channels_do_not_tell_is_left_out(missing):
    rows = rows_of({})
    del rows[missing]
    told = condition(rows, MODEL).values
    assert ('friction [N]' in told) == (missing == 'control_current')
    assert ('leak area [m^2]' in told) == (missing == 'valve_position')


def test_a_stem_that_does_not_move_tells_no_friction():
    stuck = rows_of({}, np.full(len(TIME), 0.433e-3))
    assert not np.isfinite(condition(stuck, MODEL).friction)
    assert condition({}, MODEL) .values == Condition().values == {}
