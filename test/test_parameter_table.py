# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The documentation's table of parameters is the table that the node declares."""

from pathlib import Path

from booster_ros.control import settings as fake_controller
from booster_ros.model.outputs import OUTPUT_UNITS
from booster_ros.parameters.schema import ALL_DESCRIPTIONS, check, checked
from booster_ros.parameters.table import parameter_table

DOCUMENTS = Path(__file__).parent.parent / 'docs'
DOCUMENT = (DOCUMENTS / 'node.md').read_text(encoding='utf-8')


def documented_table(document: str, arguments: str) -> str:
    begin = f'<!-- made by: python -m booster_ros.parameters.table{arguments} -->\n'
    return document.partition(begin)[2].partition('<!-- end -->')[0]


def test_the_documented_table_is_up_to_date():
    assert documented_table(DOCUMENT, '') == parameter_table()


def test_the_documented_table_of_the_fake_controller_is_up_to_date():
    document = (DOCUMENTS / 'fake_controller.md').read_text(encoding='utf-8')
    table = parameter_table(fake_controller.DESCRIPTIONS, ())
    assert documented_table(document, ' fake_controller') == table


def test_every_output_is_documented():
    for name in OUTPUT_UNITS:
        assert f'`{name}`' in DOCUMENT


def test_every_default_is_valid():
    defaults = {name: description.default for name, description in ALL_DESCRIPTIONS.items()}
    assert check(defaults) == check({})
    assert {name: checked(name, value) for name, value in defaults.items()} == defaults
