# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What the measured stem says of where a discrepancy is born, before any name is tried."""

from dataclasses import replace

from made_search import CURRENT, P, searching, seen
import pytest

from booster_ros.diagnosis.estimation.parametrisation import put
from booster_ros.diagnosis.searching.birthplace import called_for_above, where_born
from booster_ros.diagnosis.searching.search import PLACES
from booster_ros.model.catalogue import EFFECTS

BENT_SPRING = put(P, 'actuator.spring_bend', 1500.0)
BELOW = {'stem', 'sensor'}


def born(plant, **other):
    """Return the search among all effects, narrowed by what this plant's record says."""
    search = searching(replace(seen(plant, current=CURRENT), **other), tuple(EFFECTS))
    return where_born(search, search.refit())


def test_what_the_stem_alone_lacks_is_sought_there_and_in_the_sensors():
    search = born(BENT_SPRING)
    assert search.places == BELOW
    assert {EFFECTS[name].location for name in search.names} == BELOW
    assert {'spring_nonlinearity', 'stem_friction', 'pressure_sensor_bias'} <= set(search.names)


@pytest.mark.parametrize('plant', [
    P, put(P, 'actuator.leak_area', 8e-8), put(BENT_SPRING, 'actuator.leak_area', 8e-8)],
    ids=['nothing', 'leak', 'leak and spring'])
def test_no_place_is_ruled_out_where_the_part_above_the_stem_lacks_something_or_nothing_does(plant):
    search = born(plant)
    assert search.places == PLACES
    assert search.names == tuple(EFFECTS)


def test_no_place_is_ruled_out_where_the_pressure_between_was_not_recorded():
    experiment = seen(BENT_SPRING)
    only = {'valve_position': experiment.measured['valve_position']}
    assert born(BENT_SPRING, measured=only).places == PLACES


@pytest.mark.parametrize(('leak', 'effects'), [(5e-8, ('chamber_leak',)), (0.0, None)])
def test_what_lies_above_is_told_beside_a_stem_that_sticks(leak, effects):
    plant = put(put(P, 'actuator.coulomb_friction', 80.0), 'actuator.leak_area', leak)
    search = searching(seen(plant), ('chamber_leak', 'stem_friction', 'supply_droop'))
    found = called_for_above(search, search.refit())
    assert (found and found.effects) == effects
    if effects:
        assert found.fit.parameters.actuator.leak_area == pytest.approx(leak, rel=0.1)
        assert found.fit.parameters.actuator.coulomb_friction == 0.0
