# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which rows in and after a gap of what drives the model count."""

from made_diagnosis import DECLARED
from made_record import BACK, CHAMBER, POSITION, RAMP, ROWS, TIME, record_of, step_test
import numpy as np
import pytest

from booster_ros.diagnosis.prepare.preparation import prepare
from booster_ros.model.simulation import simulate


def test_rows_after_a_gap_of_the_drive_do_not_count_until_the_chamber_has_caught_up():
    columns = step_test()
    kept = np.r_[0:150, 200:ROWS]
    gapped = {name: values[kept] for name, values in columns.items()}
    experiment = prepare(record_of(**gapped), DECLARED)
    counted = np.isfinite(experiment.measured['chamber_pressure'])
    resumed = experiment.time[150]
    assert counted[experiment.time < resumed].all()
    assert not counted[150:][experiment.time[150:] < resumed + 2.0].any()
    assert any('gaps of control_current' in note for note in experiment.notes)


def test_a_gap_in_a_pinned_drive_is_bridged_by_a_straight_line_that_does_not_count():
    pressure = RAMP.copy()
    pressure[100:150] = np.nan
    experiment = prepare(record_of(**TIME, chamber_pressure=pressure, **POSITION), DECLARED)
    assert np.allclose(experiment.pinned['chamber_pressure'], RAMP)
    counted = np.isfinite(experiment.measured['valve_position'])
    assert not counted[100:150].any()
    assert counted[:100].all()
    assert counted[160:].all()


def fast(current_after, gap=7):
    """Return a record at 100 Hz with some rows missing, and the index of the row after them."""
    time = 0.01 * np.arange(4000)
    current = np.where(time < 10.0, 0.43e-3, 0.45e-3)
    current[time >= 20.0] = current_after
    run = simulate(DECLARED, time, current, {'chamber_pressure': 215e3})
    kept = np.ones(4000, dtype=bool)
    kept[2000 - gap:2000] = False
    columns = {'time': time, 'control_current': current, **{
        name: run[name] for name in ('chamber_pressure', 'valve_position')}}
    return record_of(**{name: values[kept] for name, values in columns.items()}), 2000 - gap


@pytest.mark.parametrize(('current_after', 'gap', 'counts'), [
    (0.45e-3, 7, True), (0.4501e-3, 7, True), (0.43e-3, 7, False), (0.45e-3, 100, False)])
def test_rows_after_a_short_gap_count_where_the_drive_stands_as_before_it(
        current_after, gap, counts):
    record, row = fast(current_after, gap)
    experiment = prepare(record, DECLARED)
    assert np.isfinite(experiment.measured['chamber_pressure'][row:row + 500]).all() == counts
    assert np.isfinite(experiment.measured['chamber_pressure'][:row]).all()


def test_a_drive_slower_than_the_rows_is_no_gap_but_in_its_own_gaps():
    supply = np.full(ROWS, np.nan)
    supply[::4] = 400e3 + 1e3 * TIME['time'][::4]
    supply[100:140] = np.nan
    experiment = prepare(record_of(**TIME, **BACK, **CHAMBER, supply_pressure=supply), DECLARED)
    known = np.isfinite(experiment.measured['chamber_pressure'])
    assert known[:97].all()
    assert not known[98:139].any()
    np.testing.assert_allclose(
        experiment.pinned['supply_pressure'][:97], 400e3 + 1e3 * TIME['time'][:97])


@pytest.mark.parametrize('driven_by', ['control_current', 'back_pressure'])
def test_rows_after_a_gap_count_once_the_chamber_has_caught_up(driven_by):
    """What went on in a gap shows for as long as a large chamber takes to fill."""
    time = 0.05 * np.arange(2400)
    current = np.where((time > 20.0) & (time < 60.0), 0.46e-3, 0.40e-3)
    run = simulate(DECLARED, time, current, {'chamber_pressure': 100e3})
    here = (time < 15.0) | (time > 58.0)
    experiment = prepare(record_of(
        time=time[here], **{driven_by: run[driven_by][here]},
        chamber_pressure=run['chamber_pressure'][here] + 50.0 * np.random.default_rng(
            1).standard_normal(int(here.sum()))), DECLARED)
    missed = experiment.measured['chamber_pressure'] - experiment.predict(
        DECLARED)['chamber_pressure']
    assert np.isfinite(missed[experiment.time > 100.0]).any()
    assert np.nanmax(np.abs(missed)) < 6.0 * experiment.noise['chamber_pressure']
