# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Set point and pressure drop in records: read, held, simulated, and left out by `close_loop`."""

from made_diagnosis import DECLARED
import numpy as np
from positioner_runs import positioner
import pytest

from booster_ros.control.selection import select_profile
from booster_ros.control.settings import check
from booster_ros.diagnosis.prepare.preparation import prepare
from booster_ros.model.loop_start import start_of_run
from booster_ros.model.parameters import ParameterError
from booster_ros.model.simulation import simulate
from booster_ros.model.stream import Stream
from booster_ros.programs import simulate as program
from booster_ros.records import RecordError, read_record

CONTROLLED = '/**:\n  ros__parameters:\n    position_controller: {enabled: true}\n'
PUSHED = CONTROLLED + '    actuator: {plug_area: 1.0e-3}\n'


def write(path, text):
    path.write_text(text, encoding='utf-8')
    return path


def columns(path):
    header, *lines = path.read_text().splitlines()
    cells = np.array([line.split(',') for line in lines], dtype=float)
    return dict(zip(header.split(','), cells.T, strict=True))


def ran(tmp_path, params, table):
    """Return the status of `simulate` and what it wrote."""
    out = tmp_path / 'out.csv'
    status = program.main([
        '--params', str(write(tmp_path / 'params.yaml', params)),
        '--input', str(write(tmp_path / 'in.csv', table)), '--out', str(out)])
    return status, columns(out) if status == 0 else {}


def table_of(steps, drops=None):
    """Return a CSV of set points (m), and pressure drops (Pa), at 50 Hz, held at 4 mm at first."""
    extra = '' if drops is None else ',pressure_drop'
    text = f'time,set_point,valve_position{extra}\n'
    for k, step in enumerate(steps):
        position = '0.004' if k == 0 else ''
        drop = '' if drops is None else f',{drops[k]}'
        text += f'{0.02 * k:.2f},{step},{position}{drop}\n'
    return text


STEPS = [0.004] * 50 + [0.006] * 200


def test_simulate_follows_set_points_from_where_the_stem_is_held(tmp_path):
    status, seen = ran(tmp_path, CONTROLLED, table_of(STEPS))
    assert status == 0
    assert list(seen)[:3] == ['time', 'set_point', 'control_current']
    assert seen['set_point'] == pytest.approx(STEPS)
    assert seen['valve_position'][:50] == pytest.approx(0.004, abs=1e-6)
    assert seen['chamber_pressure'][0] == pytest.approx(187.5e3, rel=1e-6)
    assert seen['valve_position'][-1] == pytest.approx(0.006, abs=30e-6)
    run = simulate(positioner({'position_controller.enabled': True}), seen['time'],
                   seen['set_point'], {'chamber_pressure': 187.5e3, 'valve_position': 0.004})
    assert seen['valve_position'] == pytest.approx(run['valve_position'], abs=2e-9)


def test_a_pressure_drop_in_the_table_pushes_the_stem(tmp_path):
    """A step of it from 100 to 300 kPa takes 2.5 kPa more of the chamber; empty cells keep it."""
    drops = ['100000'] + [''] * 49 + ['300000'] + [''] * 199
    status, seen = ran(tmp_path, PUSHED, table_of([0.004] * 250, drops))
    assert status == 0
    assert seen['chamber_pressure'][0] == pytest.approx(187.5e3 + 1e-3 * 1e5 / 0.0796, rel=1e-5)
    assert seen['valve_position'][:50] == pytest.approx(0.004, abs=2e-6)
    assert seen['valve_position'].min() < 3.97e-3
    rise = seen['chamber_pressure'][-1] - seen['chamber_pressure'][0]
    assert rise == pytest.approx(1e-3 * 2e5 / 0.0796, rel=0.05)


def test_a_mapped_table_is_followed_as_a_plain_one_is(tmp_path):
    """In mm and kPa under other names: set point and pressure drop drive the model alike."""
    drops = [100000] * 50 + [300000] * 200
    plain = ran(tmp_path, PUSHED, table_of(STEPS, drops))[1]
    rows = ''.join(f'{0.02 * k:.2f},{step * 1e3:.3f},{drop / 1e3}{",4" if k == 0 else ","}\n'
                   for k, (step, drop) in enumerate(zip(STEPS, drops, strict=True)))
    source = write(tmp_path / 'mapped.csv', 't [s],SP [mm],dP [kPa],travel [mm]\n' + rows)
    mapping = write(tmp_path / 'map.yaml', 'time: {columns: "t [s]", unit: s}\ncolumns: {'
                    'set_point: "SP [mm]", pressure_drop: "dP [kPa]", valve_position: '
                    '"travel [mm]"}\n')
    out = tmp_path / 'mapped_out.csv'
    assert program.main(['--params', str(tmp_path / 'params.yaml'), '--input', str(source),
                         '--out', str(out), '--map', str(mapping)]) == 0
    mapped = columns(out)
    assert mapped.keys() == plain.keys()
    for name, values in plain.items():
        assert mapped[name] == pytest.approx(values, rel=1e-6, abs=1e-9), name


@pytest.mark.parametrize(('params', 'table', 'says'), [
    ('/**:\n  ros__parameters:\n    supply: {pressure: 400000.0}\n', table_of(STEPS),
     'there is no column control_current; a set_point needs position_controller.enabled: true'),
    (CONTROLLED, 'time,control_current\n0,0\n1,0\n',
     'there is no column set_point; a control_current needs position_controller.enabled: false'),
    (PUSHED, 'time,set_point,pressure_drop\n0,0.004,\n1,0.004,1e5\n',
     'row 2, column pressure_drop: the first row needs one, or the column must go'),
])
def test_what_is_missing_is_said_in_a_sentence(tmp_path, capsys, params, table, says):
    assert ran(tmp_path, params, table) == (2, {})
    assert says in capsys.readouterr().err


def test_a_start_under_a_pressure_drop_is_at_rest():
    """In the open loop too: where the stem is read, friction or not, nothing moves at first."""
    for others in ({}, {'actuator.coulomb_friction': 100.0}):
        p = positioner({'actuator.plug_area': 2e-3, **others})
        pressure = 187.5e3 + 2e-3 * 1e5 / 0.0796
        readings = {'chamber_pressure': pressure, 'valve_position': 0.004, 'pressure_drop': 1e5}
        state, departure = start_of_run(p, 0.0, 0.43e-3, readings)
        time = np.array([0.0, 0.02])
        pinned = {'pressure_drop': np.full(2, 1e5), 'chamber_pressure': np.full(2, pressure)}
        stream = Stream(p, 0.0, 0.43e-3, state, tuple(pinned), departure=departure)
        moved = np.ptp(stream.advance(time, np.full(2, 0.43e-3), pinned)['valve_position'])
        assert moved < 1e-9, others


def test_a_record_has_them_and_holds_a_missing_set_point(tmp_path):
    path = write(tmp_path / 'record.csv', 'time,set_point,valve_position,pressure_drop\n'
                 + ''.join(f'{0.1 * k:.1f},{"0.004" if k % 3 == 0 else ""},0.004{k % 2},{-2e5}\n'
                           for k in range(30)))
    record = read_record(path)
    assert set(record['set_point']) == {0.004}
    assert record['pressure_drop'][0] == -2e5  # below vacuum, which a difference may be
    assert 'missing_command' in {defect.kind for defect in record.defects}


def test_per_cent_are_refused_as_everywhere(tmp_path):
    path = write(tmp_path / 'record.csv', 'time,set_point,valve_position\n0,50,0.008\n1,60,0.008\n')
    with pytest.raises(RecordError, match=r'set_point: 50 is not plausible in m .* looks like mm'):
        read_record(path)


def test_close_loop_leaves_a_set_point_out_and_says_so(tmp_path):
    time = np.arange(0.0, 20.0, 0.05)
    pressure = 200e3 + 20e3 * np.sin(0.5 * time)
    run = simulate(DECLARED, time, np.zeros_like(time), pinned={'chamber_pressure': pressure})
    noise = np.random.default_rng(2).standard_normal((2, len(time)))
    rows = np.column_stack((
        time, 8e-3 + 1e-3 * np.sin(time), pressure + 100.0 * noise[0],
        run['valve_position'] + 5e-6 * noise[1], np.full_like(time, 1e5)))
    names = 'time,set_point,chamber_pressure,valve_position,pressure_drop'
    path = write(tmp_path / 'record.csv', names + '\n' + ''.join(
        ','.join(f'{value:.9g}' for value in row) + '\n' for row in rows))
    experiment = prepare(read_record(path), DECLARED)
    assert tuple(experiment.measured) == ('valve_position',)
    assert tuple(experiment.pinned) == ('chamber_pressure', 'pressure_drop')
    assert 'set_point is read and not used: position_controller.enabled: true in the parameters, ' \
        'with its tuning, lets it drive the model' in experiment.notes


def test_the_fake_controller_takes_set_points_in_metres(tmp_path):
    path = write(tmp_path / 'record.csv', 'time,set_point,valve_position\n0,0.004,0.004\n'
                 '1,0.006,0.004\n2,0.006,0.006\n')
    profile = select_profile(check({
        'mode': 'set_point', 'profile': 'csv', 'csv_file': str(path)}))
    assert (profile.value(0.5), profile.value(1.5), profile.duration) == (0.004, 0.006, 3.0)
    with pytest.raises(ParameterError, match=r'levels: 0\.6 is not plausible in m'):
        select_profile(check({'mode': 'set_point', 'levels': [0.004, 0.6]}))
