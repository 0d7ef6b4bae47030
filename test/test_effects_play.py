# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A term without a name that follows a play of the booster's force: a relay that rubs."""

from functools import cache

import numpy as np
from positioner_runs import (
    current_for, legs, positioner, rows, settled_at, triangle)
import pytest

from booster_ros.model.term_course import followed
from booster_ros.model.discrepancy import interpolate
from booster_ros.model.memory import CENTRED, Departure
from booster_ros.model.simulation import Plant, simulate

REACH = 0.01
S3 = 3.14e-6
LOW, HIGH = float(current_for(180e3)), float(current_for(240e3))
LEG = 30.0


def rubbing(reach):
    """Return values of a play alone: what rubs with ±`reach`, in N."""
    return {
        'discrepancy.location': 'booster', 'discrepancy.variable': 'booster_force_play',
        'discrepancy.reach': reach, 'discrepancy.knots': list(np.linspace(-11.0, 11.0, 12) / 9.0),
    }


def to_and_fro(values, compiled=True, departure=CENTRED, leg=LEG):
    """Return a run over slow ways up and down."""
    time = rows(4.0 * leg)
    return simulate(positioner(values), time, triangle(time, LOW, HIGH, leg), settled_at(180e3),
                    compiled=compiled, departure=departure)


@cache
def rubbed():
    """Return such a run with a play of `REACH`; nothing in it may be changed in place."""
    return to_and_fro(rubbing(REACH))


def force_on_the_stack(run):
    return (run['back_pressure'] * 13.52e-6 - run['outlet_pressure'] * S3
            - run['supply_pressure'] * (9.28e-6 - S3))


@pytest.mark.parametrize('reach', [0.003, REACH])
def test_a_relay_that_rubs_lags_by_its_play_on_ways_up_and_down(reach):
    run, declared = to_and_fro(rubbing(reach)), to_and_fro({})
    late = run['time'] % LEG > LEG - 1.0  # until then the chamber still comes along
    ahead = run['chamber_pressure'] - declared['chamber_pressure']
    up, down = legs(run['time'], LEG)
    assert ahead[up & late] == pytest.approx(-reach / S3, rel=0.06)
    assert ahead[down & late] == pytest.approx(reach / S3, rel=0.06)


def test_what_rubs_stands_still_until_the_force_has_crossed_the_play():
    run = rubbed()
    opening = run['booster_force']
    stack = force_on_the_stack(run)
    up, down = legs(run['time'], LEG)
    settled = np.arange(len(stack)) % round(LEG / 0.01) > 1000
    assert stack[up & settled] - opening[up & settled] == pytest.approx(REACH, abs=1e-4)
    assert stack[down & settled] - opening[down & settled] == pytest.approx(-REACH, abs=1e-4)


def test_plain_and_compiled_give_the_same_bits():
    plain, compiled = (
        to_and_fro(rubbing(REACH), compiled, leg=6.0) for compiled in (False, True))
    for name, column in plain.columns.items():
        assert np.array_equal(column, compiled[name]), name


@pytest.mark.parametrize('past', [0.0, 0.07])
def test_the_place_in_the_play_over_a_record_is_that_of_the_model(past):
    values = {**rubbing(REACH), 'discrepancy.values': [0.0, *np.linspace(1e-3, 4e-3, 10), 0.0]}
    run = to_and_fro(values, departure=Departure(past=past))
    p = positioner(values)
    places = followed(p, run['time'], run.columns, past)
    assert (places.min(), places.max()) == pytest.approx((-1.0, 1.0))
    added = [interpolate(p.discrepancy, place) - REACH * place for place in places]
    assert run['booster_force'] - force_on_the_stack(run) == pytest.approx(added, abs=1e-9)


def test_a_run_may_begin_anywhere_in_the_play():
    """What the force moves stands 7 mN up: as much force opens no seat, where -10 mN is the end."""
    begun = to_and_fro(rubbing(REACH), departure=Departure(past=0.07))
    assert begun['booster_force'][0] == pytest.approx(0.007, abs=1e-6)
    assert rubbed()['booster_force'][0] == pytest.approx(0.0, abs=1e-6)


def test_rows_further_apart_tell_of_the_same_valve():
    fine = rubbed()
    time = rows(4.0 * LEG, 0.02)
    coarse = simulate(positioner(rubbing(REACH)), time, triangle(time, LOW, HIGH, LEG),
                      settled_at(180e3))
    apart = coarse['chamber_pressure'] - fine['chamber_pressure'][::2]
    assert np.sqrt(np.mean(apart**2)) < 30.0  # the current itself comes 10 ms later


def test_a_plant_that_gets_such_a_term_goes_on_from_where_it_is():
    plant = Plant(positioner({}), 0.01)
    plant.reset(200e3, None, float(current_for(200e3)))
    plant.advance(float(current_for(200e3)), 500)
    before = plant.outputs().chamber_pressure
    plant.parameters = positioner(rubbing(REACH))
    plant.advance(float(current_for(202e3)), 1000)  # 6 mN more: within the play
    assert plant.outputs().chamber_pressure == pytest.approx(before, abs=1.0)
    plant.advance(float(current_for(210e3)), 3000)  # 31 mN: it opens, and shuts late
    assert 210e3 < plant.outputs().chamber_pressure < 210e3 + REACH / S3


def test_a_constant_beside_a_play_is_an_offset_of_the_converter():
    """From the start on: where a play rests goes by where the seats are shut."""
    table = {**rubbing(REACH), 'discrepancy.knots': list(np.linspace(-100.0, 100.0, 12))}
    extra = 0.03
    moved = {**table, 'ep_converter.offset': -extra / 13.52e-6,
             'discrepancy.values': [0.0, *[extra] * 10, 0.0]}
    time = rows(20.0)
    current = np.where(time < 2.0, LOW, HIGH)
    for begin in (180e3, 182e3):
        one, other = (simulate(positioner(values), time, current, {'chamber_pressure': begin})
                      for values in (table, moved))
        assert other['chamber_pressure'] == pytest.approx(one['chamber_pressure'], abs=50.0)
