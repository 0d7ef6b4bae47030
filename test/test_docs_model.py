# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The model's documentation names every effect and parameter as the code has them."""

from pathlib import Path
import re

import pytest

from booster_ros.model.catalogue import EFFECTS, is_of_effect
from booster_ros.model.parameters import DESCRIPTIONS

DOCS = Path(__file__).resolve().parent.parent / 'docs'
TEXT = (DOCS / 'model.md').read_text()
ROWS = {
    cells[1].strip(' `'): cells[2:]
    for cells in (line.split(' | ') for line in
                  re.findall(r'^\| `.*\|$', TEXT, flags=re.MULTILINE))
    for cells in [['', cells[0].lstrip('| '), *cells[1:]]]
}


def test_every_effect_has_a_row():
    assert set(ROWS) == set(EFFECTS)


@pytest.mark.parametrize('name', EFFECTS)
def test_location_parameters_units_and_source(name):
    location, _, parameters, source = ROWS[name]
    effect = EFFECTS[name]
    assert location == effect.location
    assert source.rstrip(' |') == effect.source
    for knob in effect.knobs:
        unit = DESCRIPTIONS[knob.parameter].unit
        assert f'`{knob.parameter}` ({knob.neutral:g} {unit})' in parameters


@pytest.mark.parametrize('name', EFFECTS)
def test_what_an_effect_needs_to_be_seen_is_told(name):
    effect = EFFECTS[name]
    sought = '; '.join(f'`{knob.parameter}` {knob.low:g} to {knob.high:g} '
                       f'{DESCRIPTIONS[knob.parameter].unit}' for knob in effect.knobs)
    row = f'| `{name}` | {effect.needs} | {effect.separating_experiment} | {sought} |'
    assert row in (DOCS / 'effects.md').read_text().splitlines()


def test_every_parameter_of_an_effect_is_explained():
    for name in DESCRIPTIONS:
        if is_of_effect(name) and not name.startswith('discrepancy'):
            assert f'`{name}`' in TEXT, name
