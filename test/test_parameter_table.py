# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The documentation's table of parameters is the table that the node declares."""

from pathlib import Path

from booster_ros.model.system import OUTPUT_UNITS
from booster_ros.parameters.schema import ALL_DESCRIPTIONS, check, checked
from booster_ros.parameters.table import parameter_table

DOCUMENT = (Path(__file__).parent.parent / 'docs' / 'node.md').read_text(encoding='utf-8')


def test_the_documented_table_is_up_to_date():
    begin = '<!-- made by: python -m booster_ros.parameters.table -->\n'
    documented = DOCUMENT.partition(begin)[2].partition('<!-- end -->')[0]
    assert documented == parameter_table()


def test_every_output_is_documented():
    for name in OUTPUT_UNITS:
        assert f'`{name}`' in DOCUMENT


def test_every_default_is_valid():
    defaults = {name: description.default for name, description in ALL_DESCRIPTIONS.items()}
    assert check(defaults) == check({})
    assert {name: checked(name, value) for name, value in defaults.items()} == defaults
