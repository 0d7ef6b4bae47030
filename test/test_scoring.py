# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Scoring close_loop on a folder of records."""

import json
from pathlib import Path
import shutil

from hidden_plant.scoring import Score, is_named, is_placed, line_of, main, scored, summary_of
import pytest

SAMPLES = Path(__file__).parent / 'samples'


def found(name, location, *rivals):
    """Return an effect as a report lists it."""
    return {'name': name, 'location': location, 'confused_with': list(rivals)}


LEAK = found('chamber_leak', 'chamber', 'exhaust_seat_leak')
FRICTION = found('stem_friction', 'stem')
UNKNOWN = found('unknown', 'stem')


@pytest.mark.parametrize(('names', 'verdict', 'effects', 'right'), [
    (['none'], 'none', [], True),
    (['none'], 'effect', [LEAK], False),
    (['chamber_leak'], 'none', [], False),
    (['chamber_leak'], 'effect', [LEAK], True),
    (['exhaust_seat_leak'], 'effect', [LEAK], True),
    (['dead_time'], 'effect', [LEAK], False),
    (['chamber_leak+stem_friction'], 'effect', [LEAK], False),
    (['chamber_leak+stem_friction'], 'effect', [FRICTION, LEAK], True),
    (['unknown', 'seat_load'], 'unknown', [UNKNOWN], True),
    (['unknown', 'seat_load'], 'effect', [found('seat_load', 'stem')], True),
    (['stem_friction'], 'unknown', [UNKNOWN], False),
])
def test_a_name_is_right_where_it_or_what_it_is_confused_with_is(names, verdict, effects, right):
    assert is_named(names, verdict, effects) is right


@pytest.mark.parametrize(('location', 'effects', 'right'), [
    ('none', [], True),
    ('none', [LEAK], False),
    ('chamber', [], False),
    ('chamber', [LEAK], True),
    ('booster', [LEAK], False),
    ('chamber+stem', [LEAK], False),
    ('chamber+stem', [FRICTION, LEAK], True),
])
def test_a_place_is_right_where_something_was_found_in_each(location, effects, right):
    assert is_placed(location, effects) is right


def test_a_summary_counts():
    one = Score('a', 'none', 'none', True, True, (1.0, 1.0), (1.0, 1.4), 10.0)
    other = one._replace(case='b', hidden='dead_time', said='none', named=False, placed=False,
                         before=(3.0, 2.0), after=(1.2, 1.6), seconds=30.0)
    assert summary_of([one, other]) == (
        '2 records: name 1, place 1, 1 of 1 clean ones left alone, 1 within 1.5 x noise, '
        '20 s (median), 30 s at the most')
    assert line_of(other) == ('b: dead_time; said none: name WRONG, place WRONG; '
                              'other record 3.00/2.00 -> 1.20/1.60 x noise; 30 s')


def test_a_folder_is_scored(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    case = 'sample_booster_dead_band'
    for name in (f'{case}.yaml', f'{case}_fit.csv', f'{case}_val.csv'):
        shutil.copy(SAMPLES / name, tmp_path)
    key = {case: {'names': ['booster_dead_band'], 'location': 'booster'}}
    (tmp_path / 'key.json').write_text(json.dumps(key))
    monkeypatch.chdir(tmp_path.parent)  # programs run elsewhere
    score, = scored(Path(tmp_path.name))
    assert score.said == 'booster_dead_band'
    assert score.named
    assert score.placed
    assert max(score.after) < 1.1 < 5.0 < min(score.before)
    assert score.near
    key[case]['location'] = 'stem'
    (tmp_path / 'key.json').write_text(json.dumps(key))
    (tmp_path / f'{case}_fit.csv').write_text('time,control_current\n')
    assert main([str(tmp_path)]) == 2
    assert f'{case}_fit.csv' in capsys.readouterr().err


def test_a_folder_without_a_key_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    assert main([str(tmp_path)]) == 2
    assert f'{tmp_path}/key.json' in capsys.readouterr().err
    (tmp_path / 'key.json').write_text('{}')
    assert main([str(tmp_path)]) == 2
    assert 'no cases' in capsys.readouterr().err
