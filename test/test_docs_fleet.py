# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What docs/fleet.md shows is there: the manifest, its files, the commands and the table."""

import re
import shlex

import pytest
from ros_process import ROOT

from booster_ros.fleet import statuses
from booster_ros.fleet.manifest import PATHS, read_manifest
from booster_ros.programs import fleet
from booster_ros.records import read_mapping, read_record

PAGE = (ROOT / 'docs' / 'fleet.md').read_text(encoding='utf-8')
BLOCKS = re.findall(r'^```\n(.*?)^```', PAGE, flags=re.MULTILINE | re.DOTALL)


def table_in(text, head):
    """Return the lines of the Markdown table that begins with this head."""
    return text[text.index(head):].partition('\n\n')[0].splitlines()


def test_the_manifest_is_the_one_that_is_there(monkeypatch):
    monkeypatch.chdir(ROOT)
    words = shlex.split(BLOCKS[1])
    assert words[:4] == ['python', '-m', 'booster_ros', 'fleet']
    options = fleet._parser().parse_args(words[4:])
    assert options.manifest.read_text() == BLOCKS[0]
    valves = {one.name: one for one in read_manifest(options.manifest)}
    folder = options.manifest.parent
    there = {name: [column for column in PATHS if getattr(valve, column)
                    and not (folder / getattr(valve, column)).exists()]
             for name, valve in valves.items()}
    assert there == {'FV-7': [], 'FV-8': [], 'FV-9': ['record']}
    mapped = read_record(folder / valves['FV-7'].record,
                         mapping=read_mapping(folder / valves['FV-7'].mapping))
    assert len(mapped) == 3000
    assert mapped['chamber_pressure'][0] == pytest.approx(71_350.0)


def test_the_command_for_a_scheduler_is_one():
    words = shlex.split(BLOCKS[2].splitlines()[-1])
    assert fleet._parser().parse_args(words[4:]).scheduler == 'tcp://HOST:8786'


def test_the_table_of_statuses_is_that_of_the_program():
    head = '| verdict | standing | status |'
    assert table_in(PAGE, head) == table_in(statuses.__doc__, head)


def test_the_columns_of_a_manifest_are_all_told():
    told = ' '.join(table_in(PAGE, '| column | has |'))
    assert all(f'`{name}`' in told for name in ('valve', *PATHS))
