# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A fleet on workers of its own, and on those of a scheduler that runs already."""

from contextlib import redirect_stdout
import io
import os
import re
import signal
import subprocess
import sys
import time

from dask_scheduler import PLAIN, scheduler
import numpy as np
import pandas as pd
import pytest
from ros_process import PATIENCE

from booster_ros.model.simulation import simulate
from booster_ros.model.system import PositionerParameters
from booster_ros.parameters.file import write_parameter_file
from booster_ros.programs.fleet import main
from booster_ros.records import CsvWriter


CLOSED = PositionerParameters()
CLOSED = CLOSED._replace(booster=CLOSED.booster._replace(opening_gain=0.0))
"""A chamber that is shut off: a diagnosis takes a second or two."""


def write_plant(folder):
    """Write a plant of a valve that lacks nothing, one that does, no record, and a torn one."""
    write_parameter_file(folder / 'closed.yaml', CLOSED)
    clock = 0.3 * np.arange(100)
    for name, area in (('none', 0.0), ('leak', 4e-8)):
        plant = CLOSED._replace(actuator=CLOSED.actuator._replace(leak_area=area))
        run = simulate(plant, clock, np.zeros(100), {'chamber_pressure': 140e3})
        noise = 100.0 * np.random.default_rng(5).standard_normal(100)
        with CsvWriter(folder / f'{name}.csv', ('time', 'chamber_pressure')) as writer:
            writer.write_rows(np.column_stack([clock, run['chamber_pressure'] + noise]))
    (folder / 'torn.csv').write_text(
        'time,control_current,chamber_pressure\n0,0.004,1e5\n1,x,1\n')
    (folder / 'plant.csv').write_text(
        'valve,record,parameters\nFV-1,gone.csv,closed.yaml\nFV-2,none.csv,closed.yaml\n'
        'FV-3,leak.csv,closed.yaml\nFV-4,torn.csv,closed.yaml\n')
    return folder / 'plant.csv'


def fleet(manifest, out, *options):
    """Run the program in this process; return what it prints."""
    said = io.StringIO()
    with redirect_stdout(said):
        assert main(words(manifest, out, *options)) == 0
    return said.getvalue()


def words(manifest, out, *options):
    return [str(manifest), '--out', str(out), '--only', 'chamber_leak', *options]


def command(manifest, out, *options):
    return [sys.executable, '-m', 'booster_ros', 'fleet', *words(manifest, out, *options)]


@pytest.fixture(scope='module')
def plant(tmp_path_factory):
    """Return the manifest of a plant, the folder of its fleet, and what was printed."""
    folder = tmp_path_factory.mktemp('plant')
    manifest = write_plant(folder)
    return manifest, folder / 'out', fleet(manifest, folder / 'out', '--jobs', '2')


def table_of(out, dtype=None):
    return pd.read_csv(out / 'fleet.csv', keep_default_na=False, dtype=dtype).set_index('valve')


def test_one_bad_record_does_not_stop_the_rest(plant):
    _, out, said = plant
    table = table_of(out)
    assert table['status'].to_dict() == {
        'FV-3': 'maintenance', 'FV-1': 'check', 'FV-4': 'check', 'FV-2': 'good'}
    assert table.loc['FV-3', 'effects'] == 'chamber_leak'
    assert table.loc['FV-3', 'discovery']
    assert "row 3, column control_current: 'x' is not a number" in table.loc['FV-4', 'message']
    assert table.loc['FV-1', 'message'] == 'gone.csv: No such file or directory'
    assert (out / table.loc['FV-2', 'report']).is_file()
    assert re.search(r'4/4 FV-\d: .*; 0 min to go', said)
    assert (out / 'fleet.html').is_file()


def test_only_what_has_changed_is_diagnosed_again(plant):
    manifest, out, _ = plant
    before = {name: (out / 'valves' / name / 'report.json').stat().st_mtime_ns
              for name in ('FV-2', 'FV-3')}
    (manifest.parent / 'torn.csv').write_text('time,control_current\n')
    said = fleet(manifest, out, '--jobs', '1')
    assert '3 of 4 valves have been diagnosed before' in said
    assert 'no rows of data' in table_of(out).loc['FV-4', 'message']
    assert before == {name: (out / 'valves' / name / 'report.json').stat().st_mtime_ns
                      for name in before}


def test_a_worker_of_a_scheduler_gives_the_same_to_the_last_digit(plant, tmp_path):
    manifest, out, _ = plant
    head, *lines = manifest.read_text().splitlines(keepends=True)
    one = manifest.with_name('one.csv')
    one.write_text(head + ''.join(line for line in lines if line.startswith('FV-3,')))
    with scheduler(tmp_path, 1) as address:
        fleet(one, tmp_path / 'out', '--scheduler', address)
    for name in ('report.json', 'report.html', 'positioner.yaml', 'positioner_before.yaml'):
        one, other = (folder / 'valves' / 'FV-3' / name for folder in (out, tmp_path / 'out'))
        assert one.read_bytes() == other.read_bytes()
    columns = ['seconds', 'cpu_seconds', 'message']
    pd.testing.assert_frame_equal(table_of(out, str).loc[['FV-3']].drop(columns=columns),
                                  table_of(tmp_path / 'out', str).drop(columns=columns))


def test_no_scheduler_at_an_address_is_one_sentence(tmp_path):
    asked = command(write_plant(tmp_path), tmp_path / 'out', '--scheduler', 'nowhere')
    done = subprocess.run(asked, env=PLAIN, capture_output=True, text=True, timeout=100,
                          check=False)
    assert done.returncode == 2
    assert len(done.stderr.splitlines()) == 1
    assert 'nowhere does not answer' in done.stderr


def still_run(folder):
    """Return the processes that have this folder among their arguments."""
    return subprocess.run(['pgrep', '-f', str(folder)], capture_output=True, check=False).stdout


def test_an_interrupted_fleet_ends_what_it_started_and_keeps_what_ended(tmp_path):
    manifest, out = write_plant(tmp_path), tmp_path / 'out'
    running = subprocess.Popen(command(manifest, out, '--jobs', '1'), env=PLAIN,
                               stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                               start_new_session=True)
    assert running.stdout.readline().startswith('1/4')
    end = time.monotonic() + PATIENCE
    while not still_run(out / 'valves'):  # the next one
        assert time.monotonic() < end
        time.sleep(0.05)
    os.killpg(running.pid, signal.SIGINT)  # as a terminal does: all that it started get it too
    _, said = running.communicate(timeout=60)
    assert running.returncode == 130
    assert said == 'fleet: interrupted; the same command goes on from here\n'
    assert not still_run(out)
    ended = len(table_of(out))
    assert 1 <= ended < 4
    assert len((out / 'valves.jsonl').read_text().splitlines()) == ended
