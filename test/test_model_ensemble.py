# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Ensembles: the numbers of single runs, whatever the number of threads."""

import re

import numpy as np
from positioner_runs import PAPER_CURRENT, positioner, rows
import pytest
from ros_process import ROOT

from booster_ros.model.ensemble import simulate_ensemble
from booster_ros.model.simulation import simulate

SETS = [
    positioner({
        'actuator.effective_area': 0.0796 * (1.0 + 0.01 * k),
        'actuator.coulomb_friction': 40.0 * (k % 3),
        'actuator.stiction': 20.0 * (k % 3),
        'tubing.restriction_area': 3e-6 * (k % 2),
    })
    for k in range(7)
]
TIME = rows(6.0)
CURRENT = np.where(TIME < 4.0, PAPER_CURRENT, 0.3e-3)


@pytest.mark.parametrize('threads', [1, 2, 5])
def test_an_ensemble_is_its_single_runs_to_the_last_bit(threads):
    columns = ('valve_position', 'chamber_pressure', 'mass_flow')
    together = simulate_ensemble(SETS, TIME, CURRENT, columns, threads=threads)
    assert tuple(together) == columns
    for k, parameters in enumerate(SETS):
        alone = simulate(parameters, TIME, CURRENT)
        assert np.ptp(alone['valve_position']) > 1e-3
        for name in columns:
            assert np.array_equal(together[name][k], alone[name]), (k, name)


def test_an_ensemble_starts_and_pins_as_a_single_run_does():
    initial = {'chamber_pressure': 120e3}
    pinned = {'supply_pressure': 390e3 + 5e3 * np.sin(TIME)}
    together = simulate_ensemble(
        SETS[:2], TIME, CURRENT, initial=initial, pinned=pinned, tolerance=0.1)
    for k in range(2):
        alone = simulate(SETS[k], TIME, CURRENT, initial, pinned, tolerance=0.1)
        assert alone['chamber_pressure'][0] == 120e3
        assert np.array_equal(together['valve_position'][k], alone['valve_position'])


def test_without_machine_code_the_numbers_are_the_same():
    short = slice(0, 120)
    plain = simulate_ensemble(SETS[:2], TIME[short], CURRENT[short], compiled=False)
    machine = simulate_ensemble(SETS[:2], TIME[short], CURRENT[short])
    for name, values in plain.items():
        assert np.array_equal(values, machine[name]), name


def test_no_sets_give_no_rows():
    assert simulate_ensemble([], TIME, CURRENT)['valve_position'].shape == (0, len(TIME))


def test_what_a_single_run_refuses_an_ensemble_refuses():
    with pytest.raises(ValueError, match='time must not fall'):
        simulate_ensemble(SETS, TIME[::-1], CURRENT)
    with pytest.raises(KeyError, match='valve_posture'):
        simulate_ensemble(SETS, TIME, CURRENT, ['valve_posture'])


def test_the_example_of_the_page_gives_what_it_says(capsys):
    """On the way up friction takes its force per area off the pressure that moves the stem."""
    page = (ROOT / 'docs' / 'simulate.md').read_text(encoding='utf-8')
    example = re.search(r'^```python\n(.*?)^```', page, re.MULTILINE | re.DOTALL)[1]
    names: dict = {}
    exec(example, names)
    said = re.search(r'# mm: (\[.*\])', example)[1]
    assert capsys.readouterr().out.strip() == said
    positions = names['seen']['valve_position']
    assert positions.shape == (3, 3000)
    short = np.array(names['frictions']) / 0.0796 / 150e3 * 0.016
    assert positions[0, -1] - positions[:, -1] == pytest.approx(short, abs=2e-6)
