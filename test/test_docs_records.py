# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The lines with which docs/records.md begins, typed as they stand."""

import json
from pathlib import Path
import re
import shutil

import numpy as np
from page_line import typed
import pytest
from ros_process import ROOT

from booster_ros.records import COLUMNS, FURTHER, read_mapping, read_record

PAGE = (ROOT / 'docs' / 'records.md').read_text(encoding='utf-8')
LINES = [line for block in re.findall(r'^```\n(.*?)^```', PAGE.split('## The mapping')[0],
                                      flags=re.MULTILINE | re.DOTALL)
         for line in block.splitlines()]


@pytest.fixture(scope='module')
def folder(tmp_path_factory) -> Path:
    """Return a folder with what the page uses, after all of its lines but the last."""
    place = tmp_path_factory.mktemp('typed')
    for name in ('docs/examples/valve_7.txt', 'test/samples/sample_chamber_leak.yaml'):
        (place / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, place / name)
    for line in LINES[:-1]:
        typed(line, place)
    return place


def test_the_file_that_comes_out_is_the_record_that_was_exported(folder):
    assert [line.split()[0] for line in LINES] == ['python', 'sed', 'echo', 'python', 'python']
    written = read_record(folder / 'valve_7.csv')
    original = read_record(ROOT / 'test' / 'samples' / 'sample_chamber_leak_fit.csv')
    assert len(written) == 3000
    np.testing.assert_allclose(written['time'], original['time'][::5], atol=1e-6)
    missing = np.isnan(written['chamber_pressure'])
    assert np.flatnonzero(missing).tolist() == [700, 701, 702]
    for name, digits in (('chamber_pressure', 0.6), ('valve_position', 1e-7),
                         ('control_current', 1e-9)):
        apart = np.abs(written[name] - original[name][::5])[~missing]
        assert apart.max() < digits, name
    assert 'data-plot="look"' in (folder / 'valve_7.html').read_text()


@pytest.mark.campaign
def test_the_last_line_ends_in_a_report(folder):
    """It takes a minute, and is the one way from an export to a report that is all typed."""
    typed(LINES[-1], folder)
    report = json.loads((folder / 'result' / 'report.json').read_text(encoding='utf-8'))
    key = json.loads((ROOT / 'test' / 'samples' / 'key.json').read_text(encoding='utf-8'))
    assert [one['name'] for one in report['effects']] == ['chamber_leak']
    assert 'chamber_leak' in key['sample_chamber_leak']['names']
    assert any('mean none' in note for note in report['notes'])
    assert 'docs/examples/valve_7.txt' in (folder / 'result' / 'report.html').read_text()


def test_the_example_of_a_mapping_is_one(tmp_path):
    text = re.search(r'^```yaml\n(.*?)^```', PAGE, flags=re.MULTILINE | re.DOTALL)[1]
    path = tmp_path / 'm.yaml'
    path.write_text(text, encoding='utf-8')
    mapping = read_mapping(path)
    assert set(mapping.columns) <= {*COLUMNS, *FURTHER}
    named = set(re.findall(r'^\| `([a-z]+)', PAGE.split('## The mapping')[1].split('## Columns')[0],
                           flags=re.MULTILINE))
    assert {line.split(':')[0] for line in text.splitlines() if line[0] != ' '} <= named
