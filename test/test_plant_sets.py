# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The sets of the hidden plant that stay the same, and sets that are disturbed."""

from collections import Counter
import json
import math

import hidden_plant
from hidden_plant import cases
from hidden_plant.__main__ import main
from hidden_plant.cases import Case, write_case
from hidden_plant.disturbance import disturbed_text, write_disturbed
from hidden_plant.sets import (
    LADDER, LADDER_NOISES, LADDER_SEEDS, add_samples, golden, ladder, quick)
import numpy as np
import pytest


@pytest.fixture
def undrawn(monkeypatch):
    """Take every effect as seen, which is what takes long when a set is drawn."""
    monkeypatch.setattr(hidden_plant.campaigns, 'visibility', lambda case: (math.inf, math.inf))


@pytest.fixture
def short(monkeypatch):
    monkeypatch.setattr(cases, 'FIT_SECONDS', 12.0)
    monkeypatch.setattr(cases, 'VALIDATION_SECONDS', 6.0)
    monkeypatch.setattr(cases, 'WARM_UP_SECONDS', 5.0)


def test_the_golden_set_has_forty_cases_with_the_samples(undrawn, tmp_path):
    drawn = golden()
    assert Counter(len(case.effects) for case in drawn) == {0: 4, 1: 26, 2: 5}
    assert drawn == golden()
    added = add_samples(tmp_path)
    assert len(drawn) + len(added) == 40
    assert sorted(json.loads((tmp_path / 'key.json').read_text())) == added
    assert len(list(tmp_path.glob('*_fit.csv'))) == len(list(tmp_path.glob('*.yaml'))) == 5


def test_the_quick_set_has_sixty_cases_of_two_drawn_ones(undrawn):
    drawn = quick()
    assert len({case.name for case in drawn}) == len(drawn) == 60
    assert Counter(case.name.split('_')[0] for case in drawn) == {'4507': 31, '6101': 29}
    assert sum(not case.effects for case in drawn) == 10
    contents = {key for case in drawn for key, _ in case.effects}
    both = hidden_plant.campaigns.unseen(4507, 'samples') + hidden_plant.campaigns.unseen(
        6101, 'samples')
    assert contents == {key for case in both for key, _ in case.effects}


def test_the_ladder_has_one_valve_at_every_noise():
    steps = ladder()
    assert len({case.name for case in steps}) == len(steps) == 105
    assert len(LADDER) * len(LADDER_SEEDS) * len(LADDER_NOISES) == 105
    by_valve = Counter((case.seed, case.effects) for case in steps)
    assert set(by_valve.values()) == {5}
    assert sum('friction' in case.effects[0][0] for case in steps) == 75
    assert {round(150.0 * case.noise) for case in steps} == {0, 5, 50, 150, 450}


def test_a_case_at_another_noise_has_finer_digits_and_the_same_currents(short, tmp_path):
    def written(noise: float) -> tuple[dict, np.ndarray]:
        case = Case(f'{noise:g}', (('chamber_leak', 3e-8),), seed=5, noise=noise, resolution=noise)
        key = write_case(case, tmp_path)
        return key, np.genfromtxt(tmp_path / f'{noise:g}_fit.csv', delimiter=',', names=True)

    _, exact = written(0.0)
    key, loud = written(3.0)
    assert key['noise'] == {'chamber_pressure': 450.0, 'valve_position': pytest.approx(24e-6)}
    assert key['parameters']['actuator.leak_area'] == 3e-8
    assert key['parameters']['actuator.bench_set[1]'] == pytest.approx(300e3)
    np.testing.assert_array_equal(exact['control_current'], loud['control_current'])
    assert np.std(loud['chamber_pressure'] - exact['chamber_pressure']) == pytest.approx(450.0, 0.1)
    assert np.std(loud['valve_position'] - exact['valve_position']) == pytest.approx(24e-6, 0.1)
    steps = loud['chamber_pressure'] / 75.0
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-6)
    assert np.unique(exact['chamber_pressure'] % 1.0).size > 100


def test_what_the_model_says_otherwise_has_no_true_size(short, tmp_path):
    def known(*keys: str, spread: str = 'samples') -> dict:
        effects = tuple((key, hidden_plant.effects.EFFECTS[key].size('medium')) for key in keys)
        return write_case(Case('case', effects, seed=5, spread=spread), tmp_path)['parameters']

    assert len(known()) == 11
    pair = known('chamber_leak', 'stem_friction')
    assert pair['actuator.stiction'] == pytest.approx(0.35 * pair['actuator.coulomb_friction'])
    assert known('spool_holes') == known('chamber_leak', 'spool_holes') == {}
    assert known('chamber_leak', spread='wide') == {}  # its diaphragm is not the declared one


def test_a_disturbed_set_is_the_same_but_for_last_digits(short, tmp_path, capsys):
    given, folder = tmp_path / 'given', tmp_path / 'disturbed'
    assert main(['--cases', 'none', '--out', str(given)]) == 0
    words = ['--disturb', '1e-3', '--of', str(given), '--out', str(folder)]
    assert main(words) == 0
    for name in ('key.json', 'none.yaml'):
        assert (folder / name).read_text() == (given / name).read_text()
    for name in ('none_fit.csv', 'none_val.csv'):
        before, after = (np.loadtxt(path / name, delimiter=',', skiprows=1)
                         for path in (given, folder))
        off = np.where(before == 0.0, np.nan, after) / np.where(before == 0.0, 1.0, before) - 1.0
        assert np.nanstd(off, axis=0) == pytest.approx([1e-3] * 4, rel=0.15)
        assert np.abs(np.nanmean(off)) < 1e-4
        assert np.all(after[before == 0.0] == 0.0)
        assert after[0, 0] == 0.0
    text = (folder / 'none_fit.csv').read_text()
    assert main(words) == 0
    assert (folder / 'none_fit.csv').read_text() == text
    capsys.readouterr()
    assert main([*words[:-1], str(given)]) == 2
    assert 'is the set itself' in capsys.readouterr().err
    assert main(['--disturb', '1e-7', '--out', str(folder)]) == 2
    assert '--disturb and --of go together' in capsys.readouterr().err


def test_empty_cells_stay_empty_and_words_are_named(tmp_path):
    draws = np.random.default_rng(1)
    assert disturbed_text('a,b\n1,\n,0\n', 1e-9, draws).splitlines()[2] == ',0'
    (tmp_path / 'key.json').write_text('{"c": {}}')
    (tmp_path / 'c.yaml').write_text('')
    (tmp_path / 'c_fit.csv').write_text('a\nword\n')
    with pytest.raises(ValueError, match=r'c_fit\.csv: could not convert .*word'):
        list(write_disturbed(tmp_path, tmp_path / 'out', 1e-7, 1))
