# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The lines of docs/plant.md, typed as they stand, print what the page shows."""

from pathlib import Path
import re
import shlex
import shutil

import made_plant_export
import made_plant_trend
from page_line import typed
import pytest
from ros_process import ROOT

from booster_ros.diagnosis.prepare.preparation import prepare
from booster_ros.model.parameters import from_values
from booster_ros.parameters.file import read_parameter_file
from booster_ros.programs import close_loop
from booster_ros.records import read_mapping, read_record

PAGE = (ROOT / 'docs' / 'plant.md').read_text(encoding='utf-8')
BLOCKS = re.findall(r'^```(\w*)\n(.*?)^```\n', PAGE, re.MULTILINE | re.DOTALL)
LINES = [line for kind, block in BLOCKS if not kind for line in block.splitlines()]
SHOWN = [block for kind, block in BLOCKS if kind == 'text']
FILES = ('docs/examples/fv_211.csv', 'docs/examples/fv_304.csv', 'config/closed_loop.yaml')
DECLARED = from_values(read_parameter_file(ROOT / FILES[-1]).physical)
DIAGNOSIS = 'python -m booster_ros close_loop '


@pytest.fixture(scope='module')
def place(tmp_path_factory) -> Path:
    """Return a folder with what the page uses."""
    place = tmp_path_factory.mktemp('plant')
    for name in FILES:
        (place / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, place / name)
    return place


@pytest.fixture(scope='module')
def printed(place) -> dict[str, str]:
    """Return what each line but the diagnosis, which takes minutes, prints when typed."""
    seen = {}
    for line in LINES:
        if line.startswith(DIAGNOSIS):
            continue
        seen[line] = typed(line, place)
    return seen


def test_the_figures_of_the_page_are_those_that_are_printed(printed):
    of_metrics = [text for line, text in printed.items() if ' metrics ' in line]
    assert len(of_metrics) == 2
    for text, shown in zip(of_metrics, SHOWN[:2], strict=True):
        assert [line for line in shown.splitlines() if line not in text.splitlines()] == []


def test_the_lines_of_the_diagnosis_are_two():
    trend, export = (close_loop._parser().parse_args(shlex.split(line)[4:])
                     for line in LINES if line.startswith(DIAGNOSIS))
    assert trend.record == Path('docs/examples/fv_304.csv')
    assert trend.map == Path('fv_304.map.yaml')
    assert export.record == Path('fv_211.si.csv')


def test_a_set_point_drives_both_records_of_the_page(printed, place):
    for name, mapping, slow in (('fv_211.si.csv', None, False),
                                ('docs/examples/fv_304.csv', 'fv_304.map.yaml', True)):
        read = read_mapping(place / mapping) if mapping else None
        record = read_record(
            place / name, mapping=read, travel=DECLARED.actuator.travel)
        experiment = prepare(record, DECLARED)
        assert experiment.drives == ('set_point',)
        assert experiment.is_slow == slow


@pytest.mark.parametrize(('maker', 'name'), [(made_plant_export, 'fv_211.csv'),
                                             (made_plant_trend, 'fv_304.csv')])
def test_a_record_is_the_one_that_its_maker_writes(maker, name, tmp_path):
    maker.write(tmp_path / 'made.csv')
    assert (tmp_path / 'made.csv').read_bytes() == (ROOT / 'docs' / 'examples' / name).read_bytes()
