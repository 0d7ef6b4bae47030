# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The fleet: manifests, evidence over a plant, statuses, table and page."""

from dataclasses import replace
import json
from math import exp, log

from made_diagnosis import MADE
from made_report import FROM, Page
import numpy as np
import pandas as pd
import pytest

from booster_ros.fleet.false_discovery import CLASSES, LEAST, kept, log_e_value, log_weight
from booster_ros.fleet.manifest import FleetError, read_manifest
from booster_ros.fleet.outcome import Outcome, answer_of, line_of, read_outcomes
from booster_ros.fleet.statuses import ORDER, status_of
from booster_ros.fleet.table import page_of, rows_of, write_tables
from booster_ros.model.catalogue import EFFECTS
from booster_ros.report.json_report import json_text

HEAD = 'valve,record,parameters,mapping,validation,validation_mapping'


def manifest(folder, *lines):
    """Return a manifest of these lines."""
    path = folder / 'plant.csv'
    path.write_text('\n'.join(lines) + '\n', encoding='utf-8')
    return path


def test_a_manifest_has_a_row_for_each_valve(tmp_path):
    valves = read_manifest(manifest(
        tmp_path, HEAD, 'FV-1,a.csv,p.yaml,,,', '', ',b.csv,p.yaml,m.yaml,v.csv,w.yaml'))
    assert [one.name for one in valves] == ['FV-1', 'b']
    assert valves[0].words() == ['--record', 'a.csv', '--params', 'p.yaml']
    assert valves[1].words()[4:] == [
        '--map', 'm.yaml', '--validation', 'v.csv', '--validation-map', 'w.yaml']


@pytest.mark.parametrize(('lines', 'says'), [
    (['valve,record', 'a,b'], 'no column parameters'),
    (['record,parameters,tag'], "'tag' is no column"),
    (['record,parameters'], 'has no valve'),
    (['record,parameters', 'a.csv'], 'row 2: has 1 cells, the header 2'),
    (['record,parameters', 'a.csv,'], 'row 2: parameters is empty'),
    (['valve,record,parameters', '../x,a.csv,p.yaml'], 'cannot be the name of a folder'),
    (['valve,record,parameters', 'x,a.csv,p.yaml', 'x,b.csv,p.yaml'], 'row 3: there is a valve x'),
    (['record,parameters,validation_mapping', 'a,b,c'], 'no validation'),
    (['record,record,parameters', 'a,b,c'], 'there twice')])
def test_a_manifest_that_makes_no_sense_is_one_sentence(tmp_path, lines, says):
    with pytest.raises(FleetError, match=says):
        read_manifest(manifest(tmp_path, *lines))


def test_a_valve_is_known_by_what_is_in_its_files(tmp_path):
    for name in ('a.csv', 'p.yaml'):
        (tmp_path / name).write_text(name)
    valve, = read_manifest(manifest(tmp_path, 'record,parameters', 'a.csv,p.yaml'))
    before = valve.digest(tmp_path, ())
    assert valve.digest(tmp_path, ()) == before
    assert valve.digest(tmp_path, ('--only', 'stem_friction')) != before
    (tmp_path / 'a.csv').write_text('b')
    assert valve.digest(tmp_path, ()) != before
    (tmp_path / 'a.csv').unlink()
    assert valve.digest(tmp_path, ()) not in (before, '')


def test_weights_of_all_models_are_no_more_than_one():
    names = list(EFFECTS)
    singles = sum(exp(log_weight([name])) for name in names)
    pairs = sum(exp(log_weight([one, other])) for k, one in enumerate(names)
                for other in names[:k])
    assert singles == pytest.approx(1.0 / CLASSES)
    assert pairs == pytest.approx(1.0 / CLASSES)
    assert log_weight(['chamber over valve_position']) < -log(CLASSES)


def step(effects, against, log_evidence):
    """Return a step of a trace, as far as evidence is asked for."""
    return {'effects': effects, 'against': against, 'log_evidence': log_evidence}


def test_only_what_speaks_against_the_declared_model_is_evidence():
    alone = step(['stem_friction'], [], 30.0)
    found = log_e_value([alone, step(['chamber_leak'], [], 20.0),
                         step(['stem_friction', 'chamber_leak'], ['stem_friction'], 900.0)])
    assert found == pytest.approx(30.0 - log(CLASSES * len(EFFECTS)))
    assert log_e_value([]) == log_e_value([step(['stem_friction'], [], None)]) == LEAST


def test_of_valves_that_lack_nothing_no_more_than_the_rate_is_kept():
    """Bayes factors of a mean of 20 values, N(0, 1) or not, are e-values; a quarter has a mean."""
    rng = np.random.default_rng(3)
    count, rows, spread, rate = 200, 20, 1.0, 0.2
    shares, found = [], []
    for _ in range(300):
        lacks = np.arange(count) < count // 4
        mean = rng.normal(0.0, 1.0 / np.sqrt(rows), count) + lacks * rng.normal(0.0, 1.5, count)
        variance = spread**2 + 1.0 / rows
        log_e = 0.5 * (np.log(1.0 / rows / variance) + mean**2 * (rows - 1.0 / variance))
        chosen = np.array(kept(log_e.tolist(), rate))
        shares.append(np.sum(chosen & ~lacks) / max(chosen.sum(), 1))
        found.append(np.mean(chosen[lacks]))
    assert np.mean(shares) <= rate
    assert np.mean(found) > 0.3  # and some are found


def test_one_valve_needs_more_evidence_among_many():
    assert kept([log(20.0)], 0.05) == [True]
    assert kept([log(20.0), *[0.0] * 19], 0.05) == [False] * 20
    assert kept([log(400.0), *[0.0] * 19], 0.05) == [True, *[False] * 19]
    assert kept([log(100.0)] * 5 + [0.0] * 15, 0.05) == [True] * 5 + [False] * 15
    assert kept([], 0.05) == []


@pytest.mark.parametrize(('kind', 'standing', 'is_kept', 'status'), [
    ('silent', 'confirmed', False, 'failure'), ('changed', '', False, 'out of specification'),
    ('unknown', 'likely', True, 'out of specification'), ('unknown', 'likely', False, 'good'),
    ('effect', 'confirmed', True, 'maintenance'), ('effect', 'candidate', True, 'check'),
    ('effect', 'confirmed', False, 'good'), ('none', '', False, 'good'),
    ('no answer', '', False, 'check')])
def test_statuses(kind, standing, is_kept, status):
    assert status_of(kind, standing, is_kept) == status
    assert status in ORDER


@pytest.mark.parametrize(('name', 'kind'), [
    ('effect', 'effect'), ('none', 'none'), ('unknown', 'unknown')])
def test_an_outcome_is_read_from_a_report_and_kept(tmp_path, name, kind):
    report = json.loads(json_text(MADE[name](), FROM))
    answer = answer_of(report)
    assert answer['kind'] == kind
    assert answer['effects'] == tuple(one['name'] for one in report['effects'])
    errors = report['held_out'].values()
    assert answer['misfit'] == max(one['before'] / one['noise'] for one in errors)
    outcome = Outcome('FV-1', 'a', 'b', 'answered', **answer)
    text = line_of(replace(outcome, summary='old')) + line_of(outcome)
    (tmp_path / 'valves.jsonl').write_text(f'{text}{{"valve": "cut o', encoding='utf-8')
    assert read_outcomes(tmp_path) == {'FV-1': outcome}
    (tmp_path / 'valves.jsonl').write_text('{}\n')
    with pytest.raises(FleetError, match='not a file of outcomes'):
        read_outcomes(tmp_path)


def test_a_change_on_the_way_is_told_where_nothing_is_missing_since():
    report = json.loads(json_text(MADE['none'](), FROM))
    change = {'silent': [], 'cut': True}
    assert answer_of({**report, 'change': change})['kind'] == 'changed'
    assert answer_of({**report, 'change': {**change, 'cut': False}})['kind'] == 'none'
    assert answer_of({**report, 'verdict': 'effect', 'change': change})['kind'] == 'effect'
    change['silent'] = ['valve_position']
    assert answer_of({**report, 'verdict': 'unknown', 'change': change})['kind'] == 'silent'


OUTCOMES = [
    Outcome('good', '', '', 'answered', kind='none', misfit=1.0, summary='Enough.'),
    Outcome('torn', '', '', 'refused', message='torn.csv: <b>x</b> is not a number'),
    Outcome('F 1', '', '', 'answered', kind='effect', effects=('stem_friction',), location='stem',
            standing='confirmed', misfit=9.0, left=1.0, log_e=60.0, summary='It sticks. More.'),
    Outcome('F 2', '', '', 'answered', kind='effect', effects=('chamber_leak',), location='chamber',
            standing='confirmed', misfit=1.2, left=1.0, log_e=2.0, summary='It leaks.'),
    Outcome('F 3', '', '', 'answered', kind='unknown', effects=('unknown',), standing='likely',
            misfit=4.0, left=1.1, log_e=40.0, summary='Something.'),
    Outcome('dead', '', '', 'answered', kind='silent', misfit=4.0, summary='Stands still.')]


def test_what_needs_attention_comes_first():
    rows = rows_of(OUTCOMES, 0.05)
    assert [(row.outcome.valve, row.status, row.discovery) for row in rows] == [
        ('dead', 'failure', False), ('F 3', 'out of specification', True),
        ('F 1', 'maintenance', True), ('torn', 'check', False), ('F 2', 'good', False),
        ('good', 'good', False)]
    page = Page(page_of(rows, 0.05, 7))
    assert page.references == [f'valves/{name}/report.html' for name in (
        'dead', 'F%203', 'F%201', 'F%202', 'good')]
    assert 'torn.csv: <b>x</b> is not a number' in page.texts
    assert '6 of 7 valves have been diagnosed' in page.text
    assert page.texts.count('not kept') == 1


def test_the_table_is_the_same_as_csv_and_as_parquet(tmp_path):
    pytest.importorskip('pyarrow')
    written = write_tables(tmp_path, rows_of(OUTCOMES, 0.05), 0.05, 6)
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(p.name for p in written)
    table = pd.read_parquet(tmp_path / 'fleet.parquet')
    text = pd.read_csv(tmp_path / 'fleet.csv', keep_default_na=False)
    assert list(table.columns) == list(text.columns)
    assert list(table['valve']) == list(text['valve']) == [
        'dead', 'F 3', 'F 1', 'torn', 'F 2', 'good']
    assert table['log_e'].isna().tolist() == [False, False, False, True, False, False]
    assert table['misfit'].dtype == float
