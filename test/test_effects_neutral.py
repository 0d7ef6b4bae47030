# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""An effect at its neutral value is no effect, and a vanishing one is next to none."""

from functools import cache

import numpy as np
from positioner_runs import current_for, positioner, rows, settled_at
import pytest

from booster_ros.model.catalogue import EFFECTS, is_of_effect
from booster_ros.model.parameters import DESCRIPTIONS, from_values, to_values
from booster_ros.model.simulation import Simulation, simulate
from booster_ros.model.system import PositionerParameters

NAMES = {
    'ep_converter': 'ep_hysteresis ep_drift ep_nonlinearity dead_time ep_gain_loss',
    'booster': 'booster_dead_band exhaust_asymmetry supply_seat_leak exhaust_seat_leak '
               'opening_nonlinearity plug_flow_force critical_pressure_ratio',
    'supply': 'supply_droop supply_ripple',
    'tubing': 'tubing_restriction',
    'chamber': 'chamber_leak heat_transfer dead_volume_change',
    'stem': 'stem_friction position_dependent_friction spring_nonlinearity effective_area_change '
            'bench_set_shift spring_rate_change stem_damping travel_limit seat_load flow_force '
            'process_force',
    'position_controller': 'slew_limit positioner_dead_zone feedback_backlash positioner_tuning '
                           'proportional_firmware integrating_firmware pulsing_firmware',
    'sensor': 'position_backlash position_sensor_lag position_sensor_bias pressure_sensor_lag '
              'pressure_sensor_bias',
}
TIME = rows(24.0)
CURRENT = np.select(
    [TIME < 8.0, TIME < 16.0], [current_for(320e3), current_for(130e3)], current_for(230e3))
SET_POINT = np.select([TIME < 8.0, TIME < 16.0], [12e-3, 3e-3], 8e-3)
START = settled_at(140e3) | {'pressure_drop': 2e5}
OUTPUTS = ('back_pressure', 'measured_chamber_pressure', 'measured_valve_position')


def run(values: dict[str, object]) -> Simulation:
    return simulate(positioner(values), TIME, CURRENT, START)


def run_in_loop(values: dict[str, object]) -> Simulation:
    return simulate(positioner({'position_controller.enabled': True, **values}), TIME, SET_POINT,
                    {'chamber_pressure': 262.5e3, 'valve_position': 12e-3})


def is_in_loop(effect: str) -> bool:
    return EFFECTS[effect].location == 'position_controller'


@cache
def declared(in_loop: bool = False) -> Simulation:
    return run_in_loop({}) if in_loop else run({})


def distance(effect: str, share: float) -> float:
    """Return the largest change of an output, as a share of what it does in the test."""
    other = (run_in_loop if is_in_loop(effect) else run)(sized(effect, share))
    still = declared(is_in_loop(effect))
    return max(
        float(np.abs(other[name] - still[name]).max() / np.ptp(still[name])) for name in OUTPUTS)


def test_the_catalogue_has_every_name_where_it_belongs():
    expected = {name: place for place, names in NAMES.items() for name in names.split()}
    assert {name: effect.location for name, effect in EFFECTS.items()} == expected


def test_all_neutral_values_are_the_declared_model():
    neutral = {
        name: description.default for name, description in DESCRIPTIONS.items()
        if is_of_effect(name)
    }
    assert len(neutral) > 50
    assert from_values(neutral) == PositionerParameters()
    for effect in EFFECTS.values():
        for knob in effect.knobs:
            assert to_values(PositionerParameters())[knob.parameter] == knob.neutral, knob.parameter


def test_the_parameters_of_effects_are_those_that_say_whose_they_are():
    own = [name for name, description in DESCRIPTIONS.items()
           if description.meaning.partition(':')[0] in EFFECTS or name.startswith('discrepancy')]
    assert [name for name in DESCRIPTIONS if is_of_effect(name)] == own


SHAPES = sorted({
    knob.parameter: 1.37 * knob.typical or 0.37 * knob.high
    for effect in EFFECTS.values() for knob in effect.knobs if knob.shape
}.items())


@pytest.mark.parametrize(('name', 'value'), SHAPES)
def test_a_shape_means_nothing_while_the_size_is_neutral(name, value):
    changed = run({name: value})
    for column, values in declared().columns.items():
        assert np.array_equal(changed[column], values), column


def sized(effect: str, share: float) -> dict[str, object]:
    """Return the effect's values, its size this share of the way from neutral to typical."""
    values: dict[str, object] = {}
    for knob in EFFECTS[effect].knobs:
        if knob.shape:
            values[knob.parameter] = knob.typical
        elif knob.inverse:
            values[knob.parameter] = knob.from_fit(share * knob.to_fit(knob.typical))
        else:
            values[knob.parameter] = knob.neutral + share * (knob.typical - knob.neutral)
    return values


@pytest.mark.parametrize('effect', EFFECTS)
def test_machine_code_and_plain_python_give_the_same_bits(effect):
    short, in_loop = TIME < 0.4, is_in_loop(effect)
    p = positioner({**sized(effect, 1.0), 'position_controller.enabled': in_loop})
    levels = (6e-3, 5e-3) if in_loop else (current_for(320e3), current_for(130e3))
    command = np.where(TIME[short] < 0.2, *levels)
    machine, plain = (simulate(p, TIME[short], command, START, compiled=compiled)
                      for compiled in (True, False))
    for name, values in plain.columns.items():
        assert np.array_equal(machine[name], values), name


@pytest.mark.parametrize('effect', EFFECTS)
def test_an_effect_shows_at_its_typical_size_and_fades_with_it(effect):
    full, tenth, little = (distance(effect, share) for share in (1.0, 0.1, 1e-3))
    assert full > 2e-3
    assert tenth < 0.6 * full
    assert little < 0.06 * full
