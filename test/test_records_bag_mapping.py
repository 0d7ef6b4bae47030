# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Bags that are not as their types promise: noted, asked, or told by a mapping."""

import dataclasses

from made_csv import defects
from made_foreign import given
import numpy as np
import pytest
from test_records_bag import (
    ATMOSPHERE, START, TICK, float64, fluid_pressure, joint_state, write_bag)

from booster_ros.programs import inspect
from booster_ros.records import RecordError, read_mapping, read_record

SAMPLES = range(50)


def commands(count: int = 50):
    """Return commands of 4 mA upwards."""
    return [float64('/control_current', 4e-3 + 1e-5 * k, START + TICK * k)
            for k in SAMPLES[:count]]


def pressures(offset: float):
    """Return FluidPressure messages that carry this much more than gauge pressure, Pa."""
    return [fluid_pressure('/chamber_pressure', 20e3 + 100.0 * k + offset - ATMOSPHERE,
                           START + TICK * k, START + TICK * k) for k in SAMPLES]


def joints(rate: float = 1.0, **names: float):
    """Return states of joints whose stamps run at a rate of the time of recording."""
    return [joint_state('/joint_states', START + TICK * k, 10**11 + round(rate * TICK * k),
                        **{name: gain * k for name, gain in names.items()}) for k in SAMPLES]


@pytest.fixture
def inspected(tmp_path, monkeypatch, capsys):
    """Return a function that inspects a bag and returns what is printed and the mapping's path."""
    monkeypatch.chdir(tmp_path)

    def run(bag):
        assert inspect.main([str(bag)]) == 0
        return capsys.readouterr().out, tmp_path / f'{bag.name}.map.yaml'

    return run


def test_a_fluid_pressure_that_cannot_be_absolute_is_gauge_pressure(tmp_path, inspected):
    bag = write_bag(tmp_path / 'bag', [*commands(), *pressures(0.0)])
    record = read_record(bag)
    assert record['chamber_pressure'][0] == 20e3
    assert 'taken as gauge pressure' in str(defects(record, 'gauge_pressure')[0])
    text, path = inspected(bag)
    assert 'carries gauge pressure' in text
    assert read_mapping(path).columns['chamber_pressure'].gauge is True
    record = read_record(bag, mapping=read_mapping(path))
    assert record['chamber_pressure'][0] == 20e3


def test_a_fluid_pressure_that_can_be_absolute_is_absolute_unless_the_mapping_says_no(tmp_path):
    bag = write_bag(tmp_path / 'bag', [*commands(), *pressures(ATMOSPHERE)])
    assert read_record(bag)['chamber_pressure'][0] == pytest.approx(20e3)
    for gauge, first in (('true', 20e3 + ATMOSPHERE), ('false', 20e3)):
        mapping = given(tmp_path, 'columns: {chamber_pressure: {from: /chamber_pressure, '
                                  f'gauge: {gauge}}}}}')
        assert read_record(bag, mapping=mapping)['chamber_pressure'][0] == pytest.approx(first)


def test_of_several_joints_the_one_meant_is_asked_for(tmp_path, inspected):
    bag = write_bag(tmp_path / 'bag', [*commands(), *joints(a=0.0, b=1e-4, c=2e-4)])
    record = read_record(bag)
    assert 'has positions of a, b, c and was not read' in '\n'.join(record.notes)
    text, path = inspected(bag)
    assert 'which of a, b, c is the valve?' in text
    with pytest.raises(RecordError, match='joint_states'):
        read_record(bag, mapping=read_mapping(path))
    path.write_text(path.read_text().replace('joint_states:?', 'joint_states:b'))
    record = read_record(bag, mapping=read_mapping(path))
    np.testing.assert_allclose(record['valve_position'], 1e-4 * np.arange(50))


@pytest.mark.parametrize('stamps', ['bag', 'header'])
def test_two_clocks_are_told(tmp_path, inspected, stamps):
    bag = write_bag(tmp_path / 'bag', joints(rate=0.5, valve=1e-4))
    text, path = inspected(bag)
    assert 'run at 0.5 of the time of recording' in text
    mapping = read_mapping(path)
    mapping = dataclasses.replace(
        mapping, time=dataclasses.replace(mapping.time, stamps=stamps))
    record = read_record(bag, mapping=mapping)
    assert defects(record, 'two_clocks')
    step = 0.01 if stamps == 'bag' else 0.005
    np.testing.assert_allclose(np.diff(record['time']), step, atol=1e-9)


def test_two_clocks_that_run_alike_are_no_news(tmp_path):
    bag = write_bag(tmp_path / 'bag', [*commands(), *joints(valve=1e-4)])
    assert not defects(read_record(bag), 'two_clocks')


def test_a_command_that_stands_for_the_whole_bag_is_told(tmp_path, inspected):
    bag = write_bag(tmp_path / 'bag', [*commands(1), *pressures(ATMOSPHERE)])
    record = read_record(bag)
    assert (record['control_current'] == 4e-3).all()
    assert defects(record, 'latched_command')
    assert 'one message' in inspected(bag)[0]


def test_a_mapping_reads_topics_of_any_name_and_unit(tmp_path):
    bag = write_bag(tmp_path / 'bag', [
        *commands(), *(float64('/p7', 0.2 + 0.001 * k, START + TICK * k) for k in SAMPLES)])
    mapping = given(tmp_path, 'columns:\n  control_current: /control_current\n'
                              '  chamber_pressure: {from: /p7, unit: bar}')
    record = read_record(bag, mapping=mapping)
    assert record['chamber_pressure'][1] == pytest.approx(20.1e3)
    with pytest.raises(RecordError, match='topic /p8 for column chamber_pressure is not in'):
        read_record(bag, mapping=given(tmp_path, 'columns: {chamber_pressure: /p8}'))
    with pytest.raises(RecordError, match='process_value: is not read from a bag'):
        read_record(bag, mapping=given(tmp_path, 'columns: {process_value: /p7}'))


def test_a_bag_whose_clock_was_set_has_runs(tmp_path, inspected):
    first, rest = commands()[:20], commands()[20:]
    both = [*first, *pressures(ATMOSPHERE)[:20]]
    late = [(topic, kind, stamp - START + 10**9, message)
            for topic, kind, stamp, message in (*rest, *pressures(ATMOSPHERE)[20:])]
    bag = write_bag(tmp_path / 'bag', [*both, *late])
    with pytest.raises(RecordError, match=r'clock was set .*2 runs.*1: 60 messages .*run: 1'):
        read_record(bag)
    text, path = inspected(bag)
    assert 'the mapping takes 1' in text
    mapping = read_mapping(path)
    assert mapping.run == 1
    record = read_record(bag, mapping=mapping)
    np.testing.assert_allclose(record['chamber_pressure'], 20e3 + 100.0 * np.arange(20, 50))
    assert np.ptp(record['time']) == pytest.approx(0.29)
    assert 'run 1 of 2' in str(defects(record, 'run')[0])
    other = read_record(bag, mapping=dataclasses.replace(mapping, run=2))
    np.testing.assert_allclose(other['chamber_pressure'], 20e3 + 100.0 * np.arange(20))
    with pytest.raises(RecordError, match='no run 3'):
        read_record(bag, mapping=dataclasses.replace(mapping, run=3))
