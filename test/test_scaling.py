# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Valves of other sizes than the paper's: what is sought in them is in proportion."""

from dataclasses import replace

from hidden_plant import cases
from hidden_plant.cases import Case, write_case
from hidden_plant.effects import EFFECTS as HIDDEN
import pytest

from booster_ros.diagnosis.pipeline import diagnose
from booster_ros.diagnosis.estimation.parametrisation import effect_freedom
from booster_ros.model.scaling import PAPER, in_proportion, proportion
from booster_ros.diagnosis.prepare.preparation import prepare
from booster_ros.diagnosis.hypotheses.discrepancy import terms
from booster_ros.model.catalogue import EFFECTS
from booster_ros.model.parameters import DESCRIPTIONS, from_values
from booster_ros.parameters.file import read_parameter_file
from booster_ros.records import read_record

KNOBS = [knob for effect in EFFECTS.values() for knob in effect.knobs]
CURRENT, AREA = 25.0, 30.0  # times the paper's: a 4–20 mA converter, an actuator of 2.4 m²
WHATEVER_THE_SIZE = {'-', 's', 'Hz', 'rad', 'm/s', 'K/W'}


def larger(p):
    """Return a valve that does the same at so many times the current, with all areas larger."""
    ep, booster, actuator = p.ep_converter, p.booster, p.actuator
    return p._replace(
        ep_converter=ep._replace(gain=ep.gain / CURRENT),
        booster=booster._replace(
            opening_gain=AREA * booster.opening_gain, max_area=AREA * booster.max_area),
        actuator=actuator._replace(**{name: AREA * getattr(actuator, name) for name in (
            'effective_area', 'dead_volume', 'moving_mass', 'viscous_friction', 'stop_stiffness',
            'stop_damping')}))


@pytest.mark.parametrize('knob', KNOBS, ids=lambda knob: knob.parameter)
def test_the_paper_s_valve_is_the_measure(knob):
    assert in_proportion(knob, PAPER) == knob


@pytest.mark.parametrize('knob', KNOBS, ids=lambda knob: knob.parameter)
def test_a_range_goes_with_the_valve_unless_its_unit_does_not(knob):
    described = DESCRIPTIONS[knob.parameter]
    component = knob.parameter.split('.')[0]
    expected = {
        'A': CURRENT, 'Pa': 1.0, 'm': 1.0, 'm^2': AREA, 'm^3': AREA, 'Pa s/kg': 1.0 / AREA,
        'N/m': AREA, 'N s/m': AREA, 'N': 1.0 if component == 'booster' else AREA,
    } | dict.fromkeys(WHATEVER_THE_SIZE, 1.0)
    factor = expected[described.unit]
    ours = in_proportion(knob, larger(PAPER))
    assert ours.typical == pytest.approx(factor * knob.typical)
    assert ours.tried == pytest.approx([factor * value for value in knob.tried])
    assert ours.high == pytest.approx(min(factor * knob.high, described.high))
    assert ours.low == pytest.approx(max(factor * knob.low, described.low))
    assert described.low <= ours.low <= ours.high <= described.high
    assert ours.neutral == pytest.approx((factor if knob.shape else 1.0) * knob.neutral)


def test_pressures_go_with_the_supply_and_lengths_with_the_travel():
    p = PAPER._replace(supply=PAPER.supply._replace(pressure=100e3),
                       actuator=PAPER.actuator._replace(travel=0.064))
    assert proportion(p, 'sensors', 'Pa') == pytest.approx(0.25)
    assert proportion(p, 'sensors', 'm') == pytest.approx(4.0)
    assert proportion(p, 'actuator', 'N') == pytest.approx(0.25)
    for unit in ('N/m', 'N s/m'):
        assert proportion(p, 'actuator', unit) == pytest.approx(0.0625)


def test_the_area_of_a_plug_goes_with_that_of_the_diaphragm():
    (knob,) = EFFECTS['process_force'].knobs
    p = PAPER._replace(
        actuator=PAPER.actuator._replace(effective_area=0.5 * PAPER.actuator.effective_area),
        booster=PAPER.booster._replace(max_area=7.0 * PAPER.booster.max_area))
    assert in_proportion(knob, p).typical == pytest.approx(0.5 * knob.typical)
    assert in_proportion(knob, p).high == pytest.approx(0.5 * knob.high)


@pytest.mark.parametrize('unit', ['A', 'Pa', 'm^2', 'Pa s/kg', 'm^3', 'm', 'N', 'N/m', 'N s/m',
                                  'kg/s'])
def test_a_valve_that_lacks_what_counts_is_sought_in_like_the_paper_s(unit):
    nothing = PAPER._replace(
        ep_converter=PAPER.ep_converter._replace(gain=0.0),
        booster=PAPER.booster._replace(max_area=0.0),
        supply=PAPER.supply._replace(pressure=0.0),
        actuator=PAPER.actuator._replace(dead_volume=0.0, travel=0.0))
    assert proportion(nothing, 'actuator', unit) == 1.0


def test_terms_without_a_name_are_in_proportion_as_well():
    channels = ('chamber_pressure', 'valve_position')
    for paper, ours in zip(terms(channels), terms(channels, larger(PAPER))):
        grown = {'chamber': AREA, 'chamber_volume': AREA, 'stem': AREA}
        assert ours.size == pytest.approx(
            grown.get(ours.label.split(' over ')[0], 1.0) * paper.size)
        assert ours.past == paper.past


@pytest.mark.campaign
@pytest.mark.parametrize(('effect', 'parameter', 'factor'), [
    ('ep_hysteresis', 'ep_converter.hysteresis', CURRENT),
    ('chamber_leak', 'actuator.leak_area', AREA),
])
def test_a_larger_valve_with_a_larger_fault_is_told_as_the_paper_s_is(
        effect, parameter, factor, tmp_path, monkeypatch):
    monkeypatch.setattr(cases, 'FIT_SECONDS', 50.0)
    size = HIDDEN[effect].size('large')
    row = EFFECTS[effect]
    monkeypatch.setitem(EFFECTS, effect, replace(row, knobs=tuple(
        replace(knob, high=2.0 * size) if knob.parameter == parameter else knob
        for knob in row.knobs)))  # a range within which the larger fault lies in proportion alone
    write_case(Case('hidden', ((effect, size),), seed=11), tmp_path)
    declared = larger(from_values(read_parameter_file(tmp_path / 'hidden.yaml').physical))
    record = read_record(tmp_path / 'hidden_fit.csv')
    record = replace(record, columns=dict(
        record.columns, control_current=CURRENT * record['control_current']))
    diagnosis = diagnose(prepare(record, declared), declared)
    (found,) = diagnosis.effects
    assert found.name == effect
    interval = found.parameters[parameter]
    paper_range = next(free for free in effect_freedom(EFFECTS[effect])
                       if free.knob.parameter == parameter)
    assert paper_range.knob.high < interval.low < interval.high
    if effect == 'chamber_leak':
        assert interval.value == pytest.approx(factor * size, rel=0.1)
