# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
What close_loop finds in real measurements, and the page on it.

Whole diagnoses belong to the campaign.
"""

from dataclasses import replace
import re

import numpy as np
import pytest

from booster_ros.diagnosis.pipeline import diagnose
from booster_ros.diagnosis.data.experiment import rmse
from booster_ros.measured import page, remarks, supplies
from booster_ros.measured.records import (
    CHAMBERS,
    FLOW_BENCH,
    FLOW_BENCH_WITHOUT_100,
    RECORDS,
    ROOT,
    SIGNATURE,
)
from booster_ros.paper.printed import FLOW_UNIT, table_1
from booster_ros.report.names import channel_label


def names(diagnosis):
    return {effect.name for effect in diagnosis.effects}


def share_left(diagnosis, channel):
    """Return the held-out error with the effect as a share of that without."""
    return diagnosis.held_out[channel].after / diagnosis.held_out[channel].before


@pytest.fixture(scope='module')
def without_100():
    """Return the diagnosis of Table I at 150 and 200 kPa, by a few of the booster's effects."""
    experiment, declared, notes = FLOW_BENCH_WITHOUT_100.experiment()
    return diagnose(experiment, declared, notes=notes, names=(
        'booster_dead_band', 'opening_nonlinearity', 'plug_flow_force'))


@pytest.fixture(scope='module')
def whole_without_100():
    """Return what `close_loop` says of Table I at 150 and 200 kPa."""
    return FLOW_BENCH_WITHOUT_100.diagnosis()


def test_the_shorter_record_is_the_table_without_100_kpa():
    experiment, _, _ = FLOW_BENCH_WITHOUT_100.experiment()
    rows = [(series.supply_pressure, back, flow * FLOW_UNIT) for series in table_1()[1:]
            for back, flow in zip(series.back_pressure, series.mass_flow)]
    record = zip(experiment.pinned['supply_pressure'], experiment.pinned['back_pressure'],
                 experiment.measured['mass_flow'])
    assert np.array(list(record)) == pytest.approx(np.array(rows))


@pytest.mark.parametrize('effects', [
    'without_100', pytest.param('whole_without_100', marks=pytest.mark.campaign)])
def test_table_1_without_its_doubtful_series_lacks_preload_and_flow_force(effects, request):
    found = request.getfixturevalue(effects)
    assert found.verdict == 'effect'
    assert names(found) == {'booster_dead_band', 'plug_flow_force'}
    preload = next(e for e in found.effects if e.name == 'booster_dead_band')
    assert preload.parameters['booster.intake_preload'].value == pytest.approx(0.37, abs=0.02)
    assert share_left(found, 'mass_flow') < 0.25


@pytest.mark.campaign
def test_what_table_1_lacks_does_not_hang_on_its_last_digits(whole_without_100):
    experiment, declared, _ = FLOW_BENCH_WITHOUT_100.experiment()
    rounded = replace(experiment, measured={
        name: values * (1.0 + 1e-7 * np.random.default_rng(3).standard_normal(len(values)))
        for name, values in experiment.measured.items()})
    again = diagnose(rounded, declared)
    assert names(again) == names(whole_without_100)
    assert share_left(again, 'mass_flow') == pytest.approx(
        share_left(whole_without_100, 'mass_flow'), abs=0.03)


@pytest.mark.campaign
def test_table_1_lacks_a_preload():
    diagnosis = FLOW_BENCH.diagnosis()
    assert names(diagnosis) == {'booster_dead_band'}
    assert share_left(diagnosis, 'mass_flow') < 0.4


@pytest.mark.campaign
def test_the_signature_lacks_friction():
    diagnosis = SIGNATURE.diagnosis()
    assert names(diagnosis) == {'stem_friction'}
    assert share_left(diagnosis, 'valve_position') < 0.25


@pytest.mark.campaign
@pytest.mark.parametrize('record', CHAMBERS, ids=lambda record: record.name)
def test_a_sealed_chamber_leaks(record):
    diagnosis = record.diagnosis()
    assert names(diagnosis) == {'chamber_leak'}
    assert share_left(diagnosis, 'chamber_pressure') < 0.5


def test_only_the_flow_force_carries_from_one_supply_to_the_other():
    experiment, declared, _ = FLOW_BENCH.experiment()
    supply = experiment.pinned['supply_pressure']
    measured = experiment.measured['mass_flow']

    def missed(name, fitted, predicted):
        fit = supplies.best_fit(experiment, declared, supplies.MODELS[name], supply == fitted)
        flow = experiment.predict(fit.parameters)['mass_flow']
        return rmse(measured, flow, supply == predicted) / FLOW_UNIT

    force = 'preload, flow force alone resists'
    # 0.36, 0.46 and 1.68 were computed apart from this
    assert missed(force, 150e3, 200e3) == pytest.approx(0.36, abs=0.05)
    assert missed(force, 200e3, 150e3) == pytest.approx(0.46, abs=0.05)
    assert missed('preload', 150e3, 200e3) == pytest.approx(1.68, abs=0.1)


def test_a_section_says_what_the_diagnosis_does(without_100):
    text = page.section(FLOW_BENCH_WITHOUT_100, without_100)
    lacks = 'The model lacks booster dead band and plug flow force, and more than that'
    assert f'**{lacks}.**' in text
    error = without_100.held_out['mass_flow']
    assert np.isnan(error.left_open)  # what was fitted is missed as well
    row = next(line for line in text.splitlines()
               if line.startswith(f'| {channel_label("mass_flow")}, held out'))
    cells = [float(cell) for cell in row.split('|')[2:-1]]
    expected = [getattr(error, stage) / FLOW_UNIT
                for stage in ('declared', 'before', 'after', 'noise')]
    assert cells == pytest.approx(expected, rel=0.01)
    # a bench with an open outlet never moves the exhaust: it may be anything
    assert '| `booster.exhaust_preload` | 0 N | 0 to 1.00 N |' in text
    assert 'does not tell `booster.exhaust_preload`' in ' '.join(
        remarks.on(FLOW_BENCH_WITHOUT_100, without_100))


@pytest.mark.parametrize('record', [FLOW_BENCH_WITHOUT_100, SIGNATURE], ids=lambda one: one.name)
def test_what_ended_where_a_refit_ends_is_said_of_every_record(record, without_100):
    ended = replace(without_100.refitted[0], at_limit=True)
    said = remarks.on(record, replace(without_100, refitted=(ended,)))
    assert any(one.startswith(f'`{ended.name}` went from') for one in said)


def test_a_decay_that_is_read_in_steps_falls_by_what_is_between_its_ends():
    time = np.arange(0.0, 90.1, 0.1)
    pressure = 1e5 - 300.0 * (time > 15.0) - 600.0 * (time > 40.0)
    assert remarks._slopes(time, pressure) == pytest.approx([10.0, 20.0, 0.0])


def test_the_page_holds_every_record_and_its_figures_exist():
    text = (ROOT / 'docs' / 'measured.md').read_text()
    for record in RECORDS:
        assert f'## {record.title}\n' in text
        assert (ROOT / record.record_file).is_file()
    figures = re.findall(r'\]\((figures/[^)]*)\)', text)
    assert figures == [page.figure_file(record) for record in RECORDS]
    for figure in figures:
        assert (ROOT / 'docs' / figure).read_text().count('<svg') == 1
