# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Faults by name: what they are, when they are on, what they make of parameters and readings."""

from __future__ import annotations

from itertools import pairwise
import math
import statistics

import pytest

from booster_ros.faults.acting import with_faults
from booster_ros.faults.injection import condition, injection
from booster_ros.faults.kinds import ALIASES, FAULTS, SENSOR_KINDS, fault_named
from booster_ros.faults.schedule import Schedule
from booster_ros.faults.sensing import Imperfection, Sensor
from booster_ros.faults.timetable import read_timetable, read_timetable_file
from booster_ros.model.catalogue import EFFECTS
from booster_ros.model.parameters import ParameterError, from_values, to_values
from booster_ros.model.simulation import Plant

BASE = from_values({})
IDEAL = Imperfection()


def changed(*acting):
    """Return the parameters that faults (fields and share) change, with their values."""
    after = to_values(with_faults(BASE, [(injection(fields), share) for fields, share in acting]))
    return {name: value for name, value in after.items() if value != to_values(BASE)[name]}


def shares(schedule, times, outputs=None):
    """Return, for each time, the share of the one fault of a schedule."""
    found = []
    for tick, time in enumerate(times):
        schedule.advance(time, tick, lambda: outputs)
        found.append(sum(one.share for one in schedule.on))
    return found


def test_every_effect_of_the_catalogue_is_a_fault_that_changes_its_own_parameters():
    for name, effect in EFFECTS.items():
        sizes = {knob.parameter: knob for knob in effect.knobs if not knob.shape}
        values = changed(({'fault': name}, 1.0))
        assert set(values) == set(sizes), name
        for parameter, value in values.items():
            knob = sizes[parameter]
            from_neutral = knob.to_fit(value) - knob.to_fit(knob.neutral)
            of_typical = knob.to_fit(knob.typical) - knob.to_fit(knob.neutral)
            assert from_neutral == pytest.approx(of_typical, rel=1e-9), parameter
        assert changed(({'fault': name}, 0.0)) == {}


def test_every_sensor_has_every_kind_and_every_alias_a_fault():
    for sensor in ('pressure', 'position'):
        assert {f'{sensor}_sensor_{kind}' for kind in SENSOR_KINDS} <= set(FAULTS)
        assert f'{sensor}_sensor_bias' in FAULTS
    assert {'f4', 'f8', 'f9', 'f10', 'f11', 'f12', 'f13', 'f14', 'f15', 'f16'} <= set(ALIASES)
    assert fault_named('f16') is FAULTS['supply_loss']
    assert fault_named('f4') is FAULTS['stem_friction']


def test_strengths_are_words_in_the_proportion_of_damadics():
    frictions = [
        changed(({'fault': 'f4', 'strength': word}, 1.0))['actuator.coulomb_friction']
        for word in ('small', 'medium', 'big', 0.5)]
    assert frictions == [300.0, 600.0, 1200.0, 150.0]
    pressures = [
        changed(({'fault': 'f16', 'strength': word}, 1.0))['supply.pressure']
        for word in ('small', 'medium', 'big')]
    assert pressures == [300e3, 200e3, 0.0]


def test_a_fault_grows_and_falls_along_its_ramps():
    schedule = Schedule([injection(
        {'fault': 'f4', 'at': 1, 'ramp': 2, 'duration': 4, 'ramp_down': 1})])
    assert shares(schedule, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 5.5, 6.0, 7.0]) == [
        0.0, 0.0, 0.5, 1.0, 1.0, 1.0, 0.5, 0.0, 0.0]
    assert schedule.on == []
    assert schedule.waiting == 0
    early = Schedule([injection({'fault': 'f4', 'ramp': 4, 'until': 2, 'ramp_down': 2})])
    assert shares(early, [0.0, 1.0, 2.0, 3.0, 4.0]) == [0.0, 0.25, 0.5, 0.25, 0.0]


def test_it_begins_and_ends_at_a_time_a_tick_or_when_a_condition_holds():
    assert shares(Schedule([injection({'fault': 'f4', 'at_tick': 2, 'until_tick': 4})]),
                  [0.0, 0.1, 0.2, 0.3, 0.4]) == [0.0, 0.0, 1.0, 1.0, 0.0]
    third = sum([0.1] * 3)  # 0.30000000000000004, and less than that by other ways
    assert shares(Schedule([injection({'fault': 'f4', 'at': third})]), [0.2, 0.3]) == [0.0, 1.0]
    schedule = Schedule([injection({
        'fault': 'f4', 'when': 'valve_position > 0.008', 'until_when': 'valve_position <= 2e-3'})])
    outputs = Plant(BASE).outputs()
    found = []
    for tick, position in enumerate((0.007, 0.0081, 0.003, 0.002, 0.009)):
        schedule.advance(0.01 * tick, tick, lambda at=position: outputs._replace(
            valve_position=at))
        found.append(bool(schedule.on))
    assert found == [False, True, True, False, False]


def test_outputs_are_looked_at_only_where_a_condition_asks_for_them():
    def see():
        raise AssertionError

    schedule = Schedule([injection({'fault': 'f4', 'at': 1.0})])
    schedule.advance(2.0, 200, see)
    assert len(schedule.on) == 1
    schedule.add(injection({'fault': 'f9', 'when': 'time > 3'}))
    with pytest.raises(AssertionError):
        schedule.advance(2.1, 210, see)


def test_of_one_fault_that_is_injected_again_the_later_one_counts():
    schedule = Schedule()
    schedule.add(injection({'fault': 'f4', 'strength': 'big'}))
    schedule.add(injection({'fault': 'stem_friction', 'strength': 'small'}))
    schedule.add(injection({'fault': 'stem_friction', 'at': 5.0}))
    schedule.advance(0.0, 0, lambda: None)
    assert [one.injection.strength for one in schedule.on] == [1.0]
    assert schedule.waiting == 1
    schedule.remove('stem_friction')
    assert (schedule.on, schedule.waiting) == ([], 0)


def test_faults_that_turn_the_same_size_add_up_and_given_values_are_reached():
    friction = ({'fault': 'stem_friction'}, 1.0), ({'fault': 'position_dependent_friction'}, 0.5)
    assert changed(*friction)['actuator.coulomb_friction'] == 450.0
    values = {'fault': 'chamber_leak', 'parameters': {'actuator.leak_area': 4e-7}}
    assert changed((values, 0.25)) == {'actuator.leak_area': 1e-7}
    restricted = [changed(({'fault': 'tubing_restriction', 'strength': strength}, 1.0))[
        'tubing.restriction_area'] for strength in (0.25, 1.0, 4.0)]
    assert restricted == pytest.approx([4e-6, 2e-6, 1e-6])  # half the area, four times the drop


def test_what_leaves_its_range_or_contradicts_is_refused_in_a_sentence():
    with pytest.raises(ParameterError, match=r'together make actuator\.coulomb_friction -1200 N'):
        changed(({'fault': 'f4', 'strength': -4}, 1.0))
    with pytest.raises(ParameterError, match=r'supply\.ripple .* must not be greater than supply'):
        changed(({'fault': 'supply_ripple'}, 1.0), ({'fault': 'supply_loss'}, 1.0))


@pytest.mark.parametrize(('text', 'sentence'), [
    ('[{fault: stem_fricton}]', 'there is no fault stem_fricton; did you mean stem_friction?'),
    ('[{fault: f4}, {fault: f9, att: 1}]', 'fault 2: there is no field att; did you mean at?'),
    ('{at: 1}', 'a fault must have a name'),
    ('{fault: f4, strength: huge}', 'strength must be a number, or one of small, medium, big'),
    ('{fault: f4, strength: .nan}', 'strength must be a number'),
    ('{fault: f4, at: -1}', 'at must be a number of seconds from 0 on, got -1'),
    ('{fault: f4, ramp: yes}', 'ramp must be a number of seconds from 0 on, got True'),
    ('{fault: f4, at_tick: 1.5}', 'at_tick must be a whole number from 0 on'),
    ('{fault: f4, at: 1, at_tick: 2}', 'one of at, at_tick, not all of them'),
    ('{fault: f4, until: 2, duration: 1}', 'either duration or until, not both'),
    ('{fault: f4, when: position > 1}', 'there is no output position; did you mean valve_position'),
    ('{fault: f4, when: valve_position is big}', 'a condition is an output, one of > < >= <='),
    ('{fault: f4, when: valve_position > 8mm}', "compares with a number in SI units, got '8mm'"),
    ('{fault: f4, size: 3}', 'size is for faults of a sensor'),
    ('{fault: position_sensor_noise, size: -1}', 'size must be a number from 0 on'),
    ('{fault: position_sensor_dead, parameters: {a: 1}}', 'has a size, and no parameters'),
    ('{fault: f4, parameters: {a: 1}}', 'there is no parameter a'),
    ('{fault: f4, parameters: {supply.pressure: 9e9}}', 'supply.pressure must be between'),
    ('{fault: f4, parameters: {booster.orifice_law: iso_6358}}', 'it is no number'),
    ('{fault: f4, parameters: 3}', 'parameters must be names and values, got 3'),
    ('[3]', 'fault 1: a fault has fields'),
    ('three', "a fault has fields (fault: stem_friction, at: 5.0), got 'three'"),
    ('[', 'line 1: not YAML'),
    ('{fault: f4, at: 1\nat: 2', 'line 2: not YAML'),
    ('[&a [1], *a]', 'not YAML: aliases (*name) are not read'),
    ('!!python/object:os.system {}', 'not YAML'),
    ('x' * 1_000_001, 'is longer than 1000000 characters'),
    ('[' * 100_000, 'not YAML'),
])
def test_a_timetable_that_cannot_be_read_is_refused_with_its_place(text, sentence):
    with pytest.raises(ParameterError) as refused:
        read_timetable(text)
    assert str(refused.value).startswith('the timetable')
    assert sentence in str(refused.value)
    assert '\n' not in str(refused.value)


def test_a_timetable_reads_numbers_as_ros_does_and_a_file_as_a_text(tmp_path):
    path = tmp_path / 'faults.yaml'
    text = '- fault: f9\n  parameters: {actuator.leak_area: 1e-7}\n  at: 1e1\n'
    path.write_text(text)
    assert read_timetable_file(str(path)) == read_timetable(text)
    assert read_timetable(text)[0].begin.time == 10.0
    assert read_timetable('') == read_timetable('[]') == []
    with pytest.raises(ParameterError, match=r'none\.yaml: cannot be read: No such file'):
        read_timetable_file(str(tmp_path / 'none.yaml'))


def read(values, *faults, seed=1, own=IDEAL):
    sensor = Sensor('position', seed)
    acting = [(injection({'fault': f'position_sensor_{kind}', **more}), 1.0)
              for kind, more in faults]
    return [sensor.read(value, own, acting) for value in values]


def test_readings_are_what_the_fault_says():
    ramp = [1e-5 * k for k in range(1000)]
    assert read(ramp) == ramp
    assert read(ramp, ('dead', {})) == [0.0] * 1000
    assert read(ramp, ('stuck', {})) == [0.0] * 1000
    stepped = read(ramp, ('resolution', {'size': 1e-3}))
    assert sorted({round(1e3 * value) for value in stepped}) == list(range(11))
    assert stepped == read(ramp, own=Imperfection(resolution=1e-3))
    assert max(abs(a - b) for a, b in zip(stepped, ramp)) == pytest.approx(5e-4, rel=0.03)
    held = read(ramp, ('dropout', {'strength': 2.0}))
    assert 140 < sum(a != b for a, b in zip(held, ramp)) < 260  # 0.2 of 1000
    assert all(b in (a, ramp[k]) for k, (a, b) in enumerate(pairwise(held), 1))
    spiked = [a - b for a, b in zip(read(ramp, ('spike', {'size': 2e-3})), ramp)]
    assert {round(1e3 * value) for value in spiked} == {-2, 0, 2}
    assert 2 <= sum(abs(value) > 1e-3 for value in spiked) <= 25  # 0.01 of 1000


@pytest.mark.parametrize('noisy', [
    lambda seed: read([0.0] * 4000, ('noise', {'size': 3e-5}), seed=seed),
    lambda seed: read([0.0] * 4000, own=Imperfection(noise=3e-5), seed=seed)])
def test_noise_has_the_size_that_is_given_and_depends_on_the_seed_alone(noisy):
    once = noisy(1)
    assert statistics.stdev(once) == pytest.approx(3e-5, rel=0.05)
    assert abs(statistics.mean(once)) < 4 * 3e-5 / math.sqrt(4000)
    assert once == noisy(1)
    assert once != noisy(2)


def test_a_stuck_sensor_shows_what_it_showed_last_and_is_free_again():
    sensor = Sensor('position', 0)
    stuck = [(injection({'fault': 'position_sensor_stuck'}), 1.0)]
    values = [sensor.read(1.0, Imperfection(), []), sensor.read(2.0, Imperfection(), stuck),
              sensor.read(3.0, Imperfection(), stuck), sensor.read(4.0, Imperfection(), []),
              sensor.read(5.0, Imperfection(), stuck)]
    assert values == [1.0, 1.0, 1.0, 4.0, 4.0]


def test_a_condition_knows_every_output():
    outputs = Plant(BASE).outputs()
    for name in outputs._fields:
        assert condition(f'{name} >= -1e9').holds(outputs)
        assert not condition(f'{name} < -1e9').holds(outputs)
